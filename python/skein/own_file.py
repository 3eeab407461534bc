"""An HDF5 file of a run, read and nothing more: what leads out of it to another file is refused, and what is damaged is named."""

import h5py

from .needs import Damaged, reading


class OwnFile:
    """Datasets by their path, groups and attributes of a file that a run wrote. Links to other files, and datasets whose numbers lie in other files, are
    refused: they could show a reader any file of this machine in place of a result."""

    def __init__(self, path):
        self.path = path
        with reading(path):
            self._file = h5py.File(path, "r")

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()

    def close(self):
        self._file.close()

    @property
    def attrs(self):
        return self._file.attrs

    def _own(self, name):
        """Refuses a path of which some part is a link that leads elsewhere."""
        parts = name.strip("/").split("/")
        for depth in range(1, len(parts) + 1):
            part = "/".join(parts[:depth])
            link = self._file.get(part, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise Damaged(f"{self.path}: {part} is a link to another file, '{link.filename}', which is not followed")
            if isinstance(link, h5py.SoftLink):
                raise Damaged(f"{self.path}: {part} is a link to '{link.path}'; a run writes none")

    def __contains__(self, name):
        with reading(self.path):
            self._own(name)
            return name in self._file

    def names(self, group):
        with reading(self.path):
            self._own(group)
            return list(self._file[group])

    def __getitem__(self, name):
        """The dataset, not read."""
        with reading(self.path):
            self._own(name)
            data = self._file[name]
            files = [source.file_name for source in data.virtual_sources()] if data.is_virtual else [entry[0] for entry in data.external or ()]
            for file in files:
                if data.is_virtual and file == ".":
                    continue
                raise Damaged(f"{self.path}: the numbers of {name} lie in another file, '{file}', which is not read")
            return data

    def read(self, name, key=()):
        """Numbers of a dataset. An index that it does not have is the caller's error, and stays one."""
        data = self[name]
        with reading(self.path, (OSError, RuntimeError)):
            return data[key]
