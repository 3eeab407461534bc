"""Persistence length of filaments from shapes in thermal equilibrium, with the error of tracing and an interval of 95 % (docs/traced_files.md)."""

import numpy as np

RISE = 3.841458820694124 / 2  # of minus the logarithm of the likelihood at the ends of an interval of 95 %: chi-square of one freedom
COARSEST = 0.25               # spacing of points over the persistence length
BOLTZMANN = 1.380649e-23      # J/K


class Persistence:
    """Persistence length of a set of shapes.

    value, interval       in the unit of the points; the upper end is infinite where errors of tracing could make all the bends
    noise                 standard deviation of a coordinate of a point, given or found
    shapes, angles        number of filaments, and of angles between chords (two for each in space)
    spacing               mean distance of points along the filaments
    correlation           {"s", "cosine", "model"}: distance of chords along the filament, the mean cosine between them, and that of the fitted chain
    """

    def __init__(self, value, interval, noise, shapes, angles, spacing, correlation):
        self.value, self.interval, self.noise, self.shapes, self.angles, self.spacing, self.correlation = value, interval, noise, shapes, angles, spacing, correlation

    def __repr__(self):
        low, high = self.interval
        return f"<Persistence length {self.value:.4g}, 95 %: {low:.4g} to {high:.4g}; noise {self.noise:.2g}; {self.shapes} shapes, {self.angles} angles>"

    def modulus(self, radius, temperature=298.15):
        """Young's modulus of round sections, Pa: k T times the persistence length over the second moment of area. Lengths in m."""
        return BOLTZMANN * temperature * self.value / (0.25 * np.pi * radius**4)


def persistence_length(curves, dimensions, noise=None, rest="straight"):
    """Persistence length from points along filaments: a list of arrays [points, 2 or 3], or one array [shapes, points, 2 or 3]. Shapes must be independent.

    dimensions   2: filaments that bend in a plane; 3: in space
    noise        standard deviation of a coordinate of a point, if it is known (0: none); None: found together with the persistence length
    rest         "straight"; "mean": the mean of all shapes is the shape at rest, in a plane, with as many points each

    The worm-like chain with errors of points is fitted to the angles between consecutive chords by maximum likelihood; the interval is that of the
    likelihood ratio.
    """
    if dimensions not in (2, 3):
        raise ValueError(f"dimensions is {dimensions}; it must be 2 or 3")
    if rest not in ("straight", "mean") or (rest == "mean" and dimensions == 3):
        raise ValueError(f"rest is {rest!r} with dimensions = {dimensions}; it must be \"straight\", or \"mean\" with dimensions = 2")
    shapes = _shapes(curves, dimensions)
    chords, bends = zip(*(_bends(points) for points in shapes))
    gaps, fit, turned = chords, None, 0.0
    if rest == "mean":
        gaps, bends = _about_mean(gaps, bends)
        chords = gaps
    for _ in range(3):  # lengths of arcs between points follow from the persistence length and the noise
        fit = _Likelihood(*_modes(gaps, bends, turned), None if noise is None else noise**2)
        turned = (dimensions - 2) * fit.inverse * float(np.mean(np.concatenate(chords)))
        gaps = [_arcs(chord, fit.inverse, fit.square, dimensions) for chord in chords]
    value, spacing = 1 / fit.inverse, float(np.mean(np.concatenate(gaps)))
    if spacing > COARSEST * value:
        raise ValueError(f"points are {spacing:.3g} apart, more than a quarter of the persistence length {value:.3g}; give points that are closer")
    low, high = fit.interval()
    found = float(np.sqrt(fit.square))
    return Persistence(value, (1 / high, 1 / low if low > 0 else np.inf), found, len(shapes), len(fit.power), spacing,
                       _correlation(shapes, spacing, dimensions, value, found))


def _shapes(curves, dimensions):
    """Arrays [points, dimensions]; shapes in a plane may have a third coordinate that is constant."""
    shapes = []
    for number, curve in enumerate(curves):
        points = np.asarray(curve, float)
        if points.ndim != 2 or points.shape[1] not in (dimensions, 3) or len(points) < 3:
            raise ValueError(f"shape {number} has the shape {list(points.shape)}; it must be [points, {dimensions}] with three points or more")
        if not np.isfinite(points).all():
            raise ValueError(f"shape {number} has points that are not finite")
        if points.shape[1] > dimensions and np.ptp(points[:, 2]) > 1e-6 * np.ptp(points, axis=0).max():
            raise ValueError(f"shape {number} is not in a plane of constant z; filaments in a plane need such shapes")
        shapes.append(points[:, :dimensions])
        if (np.diff(shapes[-1], axis=0) == 0).all(axis=1).any():
            raise ValueError(f"shape {number} has two consecutive points at one place")
    if not shapes:
        raise ValueError("there are no shapes")
    return shapes


def _bends(points):
    """Lengths of chords, and angles between consecutive ones [dimensions - 1, chords - 1]: in space about two directions that are carried along without twist."""
    steps = np.diff(points, axis=0)
    gaps = np.linalg.norm(steps, axis=1)
    along = steps / gaps[:, None]
    cosine = np.einsum("ij,ij->i", along[:-1], along[1:])
    if points.shape[1] == 2:
        return gaps, np.arctan2(along[:-1, 0] * along[1:, 1] - along[:-1, 1] * along[1:, 0], cosine)[None]
    axis = np.cross(along[:-1], along[1:])
    sine = np.linalg.norm(axis, axis=1)
    axis *= np.divide(np.arctan2(sine, cosine), sine, out=np.ones_like(sine), where=sine > 0)[:, None]
    across, bends = np.eye(3)[np.argmin(np.abs(along[0]))], np.empty((2, len(axis)))
    for k, turn in enumerate(axis):
        across = across - along[k] * (across @ along[k])
        across /= np.linalg.norm(across)
        bends[:, k] = turn @ across, turn @ np.cross(along[k], across)
        if sine[k] > 0:
            across = _turned(across, turn)
    return gaps, bends


def _turned(vector, turn):
    """Rodrigues' formula."""
    angle = np.linalg.norm(turn)
    axis = turn / angle
    return vector * np.cos(angle) + np.cross(axis, vector) * np.sin(angle) + axis * (axis @ vector) * (1 - np.cos(angle))


def _about_mean(gaps, bends):
    """Independent differences of the shapes from their mean: one fewer than shapes."""
    if len({len(gap) for gap in gaps}) > 1 or len(gaps) < 3:
        raise ValueError('rest = "mean" needs three shapes or more, with as many points each')
    count, table = len(bends), np.array([bend[0] for bend in bends])
    contrast = np.array([[1.0] * k + [-float(k)] + [0.0] * (count - k - 1) for k in range(1, count)])
    contrast /= np.linalg.norm(contrast, axis=1)[:, None]
    return [np.mean(gaps, axis=0)] * (count - 1), list((contrast @ table)[:, None])


def _modes(gaps, bends, turned):
    """Squares of the amplitudes of modes in which bends of the chain and of errors of points are both independent, and how much errors add to each.

    A chord points along the mean tangent of its arc, so an angle between chords has the variance (h + h')/(3 l) and the covariance h'/(6 l) with the next.
    An error e of a point turns the chords beside it by e/h. In space both are smaller by shares of h/l, `turned`, which simulated chains have shown.
    """
    power, share, known = [], [], {}
    for gap, bend in zip(gaps, bends):
        key = gap.tobytes()
        if key not in known:
            chain = np.diag((1 - 0.14 * turned) * (gap[:-1] + gap[1:]) / 3)
            chain += (1 - 0.46 * turned) * (np.diag(gap[1:-1] / 6, 1) + np.diag(gap[1:-1] / 6, -1))
            errors = np.diff(np.diff(np.eye(len(gap) + 1), axis=0) / gap[:, None], axis=0)
            root = np.linalg.cholesky(chain)
            errors = np.linalg.solve(root, errors)
            shares, modes = np.linalg.eigh(errors @ errors.T)
            known[key] = shares, np.linalg.solve(root.T, modes).T
        shares, modes = known[key]
        power.append(((modes @ bend.T) ** 2).T.ravel())
        share.append(np.tile(shares, len(bend)))
    return np.concatenate(power), np.concatenate(share)


def _arcs(chord, inverse, square, dimensions):
    """Arcs between points: chords of a chain are shorter by h^2/(12 l) in a plane and h^2/(6 l) in space. Errors make chords longer, and unequal."""
    spread, mean = chord.var(), chord.mean()
    keep = max(0.0, 1 - 2 * square / spread) if spread > 0 else 1.0
    even = mean + keep * (chord - mean)
    longer = 1 + (dimensions - 1) * mean * inverse / 12 - min((dimensions - 1) * square / mean**2, 0.5)
    return even * longer


class _Likelihood:
    """Amplitudes of mean 0 and variance `inverse` + `square` * share: the inverse persistence length and the squared noise that are most likely."""

    def __init__(self, power, share, square=None):
        self.power, self.share, self._known = power, share, square
        if not power.any():
            raise ValueError("the shapes are exactly straight")
        if square is None:
            ratio = _least(lambda r: self._cost(np.mean(power / (1 + r * share)), r), 1e-3 / share.max(), 1e4 / max(share.min(), 1e-9 * share.max()))
            self.inverse = float(np.mean(power / (1 + ratio * share)))
            self.square = ratio * self.inverse
        else:
            self.square, mean = square, np.mean(power)
            self.inverse = _least(lambda x: self._misfit(x, square), 1e-6 * mean, 10 * mean)
            if self.inverse == 0:
                raise ValueError("the noise alone makes larger bends than the shapes have")

    def _cost(self, inverse, ratio):
        return self._misfit(inverse, ratio * inverse)

    def _misfit(self, inverse, square):
        """Minus the logarithm of the likelihood."""
        variance = inverse + square * self.share
        if not variance.min() > 0:
            return np.inf
        return 0.5 * float(np.sum(np.log(variance) + self.power / variance))

    def _profile(self, inverse):
        if self._known is not None:
            return self._misfit(inverse, self._known)
        middle = max(self.square, 1e-3 * self.inverse / self.share.max())
        square = _least(lambda v: self._misfit(inverse, v), 1e-4 * middle, max(1e2 * middle, 10 * np.mean(self.power / self.share)))
        return self._misfit(inverse, square)

    def interval(self):
        """Ends of the inverse persistence length at which the likelihood has fallen by RISE."""
        top = self._misfit(self.inverse, self.square) + RISE
        ends = []
        for factor in (0.5, 2.0):
            inside, outside = self.inverse, self.inverse * factor
            while self._profile(outside) < top and 1e-6 * self.inverse < outside < 1e6 * self.inverse:
                inside, outside = outside, outside * factor
            if self._profile(outside) < top:
                ends.append(0.0 if factor < 1 else np.inf)
                continue
            for _ in range(40):
                middle = np.sqrt(inside * outside)
                inside, outside = (middle, outside) if self._profile(middle) < top else (inside, middle)
                if abs(outside / inside - 1) < 1e-5:
                    break
            ends.append(np.sqrt(inside * outside))
        return ends


def _least(cost, low, high):
    """Where a function of a number from 0 on is least: 0, or found between `low` and `high` by a scan and golden sections of the logarithm."""
    scan = np.linspace(np.log(low), np.log(high), 33)
    costs = [cost(np.exp(at)) for at in scan]
    best = int(np.argmin(costs))
    left, right = scan[max(best - 1, 0)], scan[min(best + 1, len(scan) - 1)]
    golden = 0.5 * (np.sqrt(5) - 1)
    inner = [right - golden * (right - left), left + golden * (right - left)]
    values = [cost(np.exp(at)) for at in inner]
    while right - left > 1e-7:
        if values[0] < values[1]:
            right, inner, values = inner[1], [inner[1] - golden * (inner[1] - left), inner[0]], [None, values[0]]
            values[0] = cost(np.exp(inner[0]))
        else:
            left, inner, values = inner[0], [inner[1], inner[0] + golden * (right - inner[0])], [values[1], None]
            values[1] = cost(np.exp(inner[1]))
    at = np.exp(0.5 * (left + right))
    return 0.0 if cost(0.0) <= cost(at) else float(at)


def _correlation(shapes, spacing, dimensions, length, noise):
    """Mean cosine between chords by their distance along the filament, up to half of the longest."""
    most = max(2, max(len(points) for points in shapes) // 2)
    sums, counts = np.zeros(most), np.zeros(most)
    for points in shapes:
        along = np.diff(points, axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        for lag in range(min(most, len(along))):
            cosine = np.einsum("ij,ij->i", along[:len(along) - lag], along[lag:])
            sums[lag] += cosine.sum()
            counts[lag] += len(cosine)
    seen = counts > 0
    lag = np.arange(most)[seen]
    turned = np.where(lag > 0, (lag - 1 / 3) * spacing / length, 0) + np.select([lag == 0, lag == 1], [0, 6], 4) * (noise / spacing) ** 2
    return {"s": lag * spacing, "cosine": sums[seen] / counts[seen], "model": np.exp(-0.5 * (dimensions - 1) * turned)}
