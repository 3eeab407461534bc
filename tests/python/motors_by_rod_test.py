"""Motors whose formulas hold the number of a rod: each copy of an assembly does what it does alone with its own number, and has the bits it has alone."""

import unittest

import numpy as np

from package import skein

COPIES = 11  # more than the lanes of a tile, and one of them left over
BODY = {"mass": 1.0, "inertia": [0.01, 0.02, 0.03], "spheres": {"radii": [0.05]}}
STIFF = {"stiffness": 1e4, "torsional_stiffness": 50.0}
AMPLITUDE = {"name": "amplitude", "at": [0.0, 5.0, 100.0], "value": [1.0, -1.5, 2.0], "at_unit": "1", "unit": "1"}

# Keys of a joint with a motor whose amplitude is `A`.
JOINTS = {
    "hinge": {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "motor": {"kind": "position", "value": "0.9*A*sin(20*t)", "stiffness": 300.0, "damping": 3.0}},
    "rate": {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "motor": {"kind": "rate", "value": "3*A*t", "damping": 3.0, "most": 0.4}},
    "slider": {"kind": "slider", "axis": [0.6, 0.0, -0.8], "motor": {"kind": "force", "value": "2*A*sin(20*t)"}},
    "universal": {"kind": "universal", "axis": [0.0, 1.0, 0.0], "second_axis": [0.0, 0.0, 1.0], "motor": {"kind": "position", "value": "0.2*sin(20*t)", "stiffness": 50.0},
                  "about_second": {"motor": {"kind": "position", "value": "0.3*A*sin(10*t)", "stiffness": 50.0}}},
    "spherical": {"kind": "spherical", "motor": {"kind": "position", "values": ["0.2*A*sin(20*t)", "0.1*A", "0.3*t"], "stiffness": 50.0, "damping": 0.5}},
    "events": {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "from": 0.01, "motor": {"kind": "force", "value": "2*A*cos(20*t)"}},
}


def amplitude(rod):
    return float(np.interp(rod, AMPLITUDE["at"], AMPLITUDE["value"]))


def replaced(joint, text):
    """The joint with `text` for its amplitude."""
    if isinstance(joint, dict): return {key: replaced(value, text) for key, value in joint.items()}
    if isinstance(joint, list): return [replaced(one, text) for one in joint]
    return joint.replace("A", text) if isinstance(joint, str) else joint


def scene(joint, copies, number=None, **time):
    """Copies of a bob on an arm, driven by their numbers; or one with the amplitude of a number."""
    base = {"kind": joint["kind"], "between": ["bob", "base"], "place": [0.0, 0.0, 0.0]}
    text = "amplitude(rod)" if number is None else f"({amplitude(number)!r})"
    law = STIFF if joint["kind"] != "spherical" else {"stiffness": STIFF["stiffness"]}
    return skein.Scene("motors", time={"duration": 0.05, "dt": 5e-5, **time}, table=[AMPLITUDE], load=[{"kind": "gravity"}],
                       assembly=[{"name": "pair", "placement": {"kind": "list", "origins": [[0.0, 0.0, 0.0]] * copies}}],
                       bodies=[{"name": "bob", "assembly": "pair", "placement": {"origin": [0.3, 0.0, 0.0]}, **BODY},
                               {"name": "base", "assembly": "pair", "placement": {"origin": [0.0, 0.0, 0.0]}, **BODY, "mass": 3.0}],
                       joint=[base | law | replaced(joint, text)])


def places(scene_, **options):
    with skein.Simulation(scene_, threads=1, **options) as run:
        run.step(run.steps)
        return np.concatenate([run["bob"].position, run["base"].position], axis=1)


def has_lanes(lanes):
    """True if a run for so many lanes has them."""
    with skein.Simulation(scene(JOINTS["rate"], 1), threads=1, lanes=lanes) as run:
        return f" {lanes} lane" in run.plan


class MotorsByRod(unittest.TestCase):
    def test_each_copy_does_what_its_number_says(self):
        for name, joint in JOINTS.items():
            together = places(scene(joint, COPIES))
            self.assertGreater(np.ptp(together, axis=0).max(), 1e-4, f"{name}: copies move apart")
            for copy in (0, 7, 10):
                alone = places(scene(joint, 1, copy))
                with self.subTest(joint=name, copy=copy):
                    np.testing.assert_allclose(together[copy], alone[0], rtol=0, atol=1e-12)

    def test_layouts_have_the_same_bits(self):
        """Copies in blocks of any width, and one copy after another: the lanes of a block are copies or joints."""
        for name, joint in JOINTS.items():
            whole = places(scene(joint, COPIES))
            for lanes in (1, 2, 4):
                with self.subTest(joint=name, lanes=lanes):
                    if not has_lanes(lanes): self.skipTest(f"kernels of {lanes} lanes are not built, or not for this processor")
                    np.testing.assert_array_equal(places(scene(joint, COPIES), lanes=lanes), whole)
            with self.subTest(joint=name, layout="a copy"):
                np.testing.assert_array_equal(places(scene(joint, 1))[0], whole[0])

    def test_joints_of_one_table_have_their_own_rods(self):
        """A chain whose hinges a wave drives: `rod` is the number of the first side in its group."""
        def chain(values):
            joints = [{"kind": "hinge", "between": ["link", "link"], "pairs": "next", "axis": [0.0, 1.0, 0.0], **STIFF, "motor": {"kind": "position", "value": values, "stiffness": 20.0, "damping": 0.2}}]
            if not isinstance(values, str):
                joints = [joints[0] | {"pairs": "listed", "first": [k], "second": [k + 1], "motor": joints[0]["motor"] | {"value": value}} for k, value in enumerate(values)]
            return skein.Scene("chain", time={"duration": 0.02, "dt": 2e-5}, joint=joints,
                               bodies=[{"name": "link", **BODY, "placement": {"kind": "list", "origins": [[0.2 * k, 0.0, 0.0] for k in range(6)]}}])

        def links(scene_):
            with skein.Simulation(scene_, threads=1) as run:
                return run.step(run.steps)["link"].position.copy()

        wave = links(chain("0.4*sin(50*t - 1.1*rod)"))
        np.testing.assert_allclose(wave, links(chain([f"0.4*sin(50*t - 1.1*{k})" for k in range(5)])), rtol=0, atol=1e-12)
        self.assertGreater(np.ptp(wave[..., 2]), 1e-3)

    def test_implicit_steps(self):
        joint = JOINTS["hinge"]
        together = places(scene(joint, 5, integrator="implicit_damped", dt=1e-3))
        for copy in (0, 4):
            np.testing.assert_allclose(together[copy], places(scene(joint, 1, copy, integrator="implicit_damped", dt=1e-3))[0], rtol=0, atol=1e-11)

    def test_equilibrium(self):
        """Hinged reeds that motors hold: their tips are those of reeds with constant angles."""
        def reeds(value, count):
            rods = {"name": "reed", "material": {"density": 1000.0, "youngs_modulus": 1e6}, "section": {"radius": 5e-3}, "shape": {"length": 0.1, "elements": 10},
                    "placement": {"kind": "list", "origins": [[0.0, 0.1 * k, 0.0] for k in range(count)], "tangents": [[0.0, 0.0, 1.0]] * count}}
            return skein.Scene("reeds", time={"duration": 1.0}, rods=[rods], load=[{"kind": "gravity"}],
                               joint=[{"kind": "hinge", "between": ["reed", "world"], "pairs": "same", "at": [0.0], "axis": [0.0, 1.0, 0.0], "stiffness": 1e4, "torsional_stiffness": 10.0,
                                       "motor": {"kind": "position", "value": value, "stiffness": 1.0}}])

        def tips(value, count):
            return skein.equilibrium(reeds(value, count)).positions["reed"][:, -1]

        together = tips("0.2 + 0.15*rod", 3)
        for k in range(3):
            np.testing.assert_allclose((together[k] - [0.0, 0.1 * k, 0.0]), tips(f"{0.2 + 0.15 * k!r}", 1)[0], rtol=0, atol=1e-9)

    def test_a_program_sets_their_numbers(self):
        """set_table gives each copy a number; the work of motors is that of the copies alone."""
        joint = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "motor": {"kind": "force", "value": "2*A"}}
        draw = np.random.default_rng(5).uniform(-2, 2, COPIES)
        with skein.Simulation(scene(joint, COPIES), threads=1) as run:
            run.set_table("amplitude", draw, at=np.arange(COPIES))
            run.step(run.steps)
            together, work = run["bob"].position.copy(), run.observables["joint_motor_work[J]"]
        works = 0.0
        for copy in range(COPIES):
            with skein.Simulation(scene(joint, 1), threads=1) as run:
                run.set_table("amplitude", [draw[copy], draw[copy]], at=[0.0, 1.0])
                run.step(run.steps)
                np.testing.assert_array_equal(run["bob"].position[0], together[copy], err_msg=f"copy {copy} has the bits it has alone")
                works += run.observables["joint_motor_work[J]"]
        self.assertAlmostEqual(work / works, 1.0, delta=1e-12)

    def test_numbers_without_a_joint_need_no_value(self):
        """Rod 0 is no first side: a formula that is not finite there moves the links as constants do."""
        def chain(values):
            joints = [{"kind": "hinge", "between": ["link", "link"], "pairs": "listed", "first": [k + 1], "second": [k], "axis": [0.0, 1.0, 0.0], **STIFF,
                       "motor": {"kind": "position", "value": values, "stiffness": 20.0, "damping": 0.2}} for k in range(5)]
            if not isinstance(values, str):
                joints = [joint | {"motor": joint["motor"] | {"value": value}} for joint, value in zip(joints, values)]
            return skein.Scene("chain", time={"duration": 0.02, "dt": 2e-5}, joint=joints,
                               bodies=[{"name": "link", **BODY, "placement": {"kind": "list", "origins": [[0.2 * k, 0.0, 0.0] for k in range(6)]}}])

        def links(scene_):
            with skein.Simulation(scene_, threads=1) as run:
                return run.step(run.steps)["link"].position.copy()

        np.testing.assert_allclose(links(chain("0.4*sin(50*t)/rod")), links(chain([f"0.4*sin(50*t)/{k}" for k in range(1, 6)])), rtol=0, atol=1e-12)

    def test_each_of_many_copies_is_tried(self):
        joint = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "motor": {"kind": "force", "value": "1/(rod - 1201)"}}
        with self.assertRaisesRegex(skein.RunFailed, "not finite for rod 1201 of 'bob'"): places(scene(joint, 2500, duration=1e-4))

    def test_motors_without_a_value(self):
        """Formulas that are not finite for some rod, or change with more than time and rod."""
        joint = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "motor": {"kind": "force", "value": "1/(rod - 3)"}}
        with self.assertRaisesRegex(skein.RunFailed, "not finite for rod 3 of 'bob'"): places(scene(joint, COPIES))
        joint = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "motor": {"kind": "force", "value": "if(s > 0.1, 1, 0)"}}
        with self.assertRaisesRegex(skein.RunFailed, "may change with t and rod alone"): places(scene(joint, COPIES))


if __name__ == "__main__":
    unittest.main()
