"""A page that is typed from top to bottom: its files saved, its commands given to one shell, and its numbers looked for in the output."""

import os
import pathlib
import re
import subprocess
import tempfile

BLOCK = re.compile(r"(?ms)^```(\w*)\n(.*?)^```$")
SAVED = re.compile(r"Save this as `([\w.]+)`:\s*$")
NUMBER = re.compile(r"(?<![\w.,^])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w^]|\.\d)")
AN_ERROR = "# an error"


def parts(text):
    """Of a page, in order: ("prose", text), ("file", name, text), ("shell", text), ("output", text)."""
    found, done, name = [], 0, None
    for block in BLOCK.finditer(text):
        prose = text[done:block.start()]
        done = block.end()
        found.append(("prose", prose))
        language, content = block.groups()
        saved = SAVED.search(prose)
        if language in ("toml", "python"):
            if not saved:
                raise ValueError(f"no 'Save this as' above:\n{content}")
            found.append(("file", saved[1], content))
        elif language == "text":
            found.append(("output", content))
        elif language == "":
            found.append(("shell", content))
        else:
            raise ValueError(f"a block of {language} is neither a file, nor commands, nor their output")
    found.append(("prose", text[done:]))
    return found


def significant(number):
    digits = re.sub(r"e.*|[-.]", "", number).lstrip("0")
    return len(digits.rstrip("0")) if "." not in number else len(digits)


def untrue(text, output, typed):
    """Numbers of three digits or more in prose that neither the output nor a file or command of the page has, and quoted lines that are not in the output."""
    there = set(NUMBER.findall(output)) | set(NUMBER.findall(typed))
    lines = {line.rstrip() for line in output.splitlines()}
    wrong = []
    for kind, *rest in parts(text):
        if kind == "prose":
            prose = re.sub(r"\]\([^)]*\)|`[^`]*`", " ", rest[0])
            wrong += [number for number in NUMBER.findall(prose) if significant(number) >= 3 and number not in there]
        elif kind == "output":
            for line in rest[0].splitlines():
                expression = re.compile(".*".join(re.escape(piece) for piece in line.rstrip().split("...")))
                if not any(expression.fullmatch(printed) for printed in lines):
                    wrong.append(line)
    return wrong


class Typed:
    """A shell in a home of its own, below a checkout whose build is the program under test."""

    def __init__(self, root, skein, python):
        self._folder = tempfile.TemporaryDirectory()
        self.home = pathlib.Path(self._folder.name)
        self.python, self.output, self.typed = python, "", ""
        checkout = self.home / "checkout"
        (checkout / "build/bin").mkdir(parents=True)
        (checkout / "build/bin/skein").symlink_to(skein)
        for folder in ("python", "apps"):
            (checkout / folder).symlink_to(pathlib.Path(root, folder))
        self.place, self.environment = checkout, dict(os.environ, HOME=str(self.home), PYTHON=python)

    def close(self):
        self._folder.cleanup()

    def give(self, commands):
        """A block of commands, line by line, in the shell of the blocks before. Raises AssertionError where one fails that the page does not announce."""
        for line in re.sub(r"\\\n", " ", commands).splitlines():
            if not line.strip():
                continue
            words = line.replace("/usr/bin/python3", self.python)
            done = subprocess.run(["bash", "-c", f"{words}\ncode=$?\nexport -p > '{self.home}/exported'\npwd > '{self.home}/place'\nexit $code"], cwd=self.place,
                                  env=self.environment, capture_output=True, text=True, timeout=250)
            self.output += done.stdout + done.stderr
            self.typed += line + "\n"
            if (done.returncode != 0) != (AN_ERROR in line):
                raise AssertionError(f"{line}\n{done.returncode}\n{done.stdout}{done.stderr}")
            self.place = pathlib.Path((self.home / "place").read_text().strip())
            for name in ("PATH", "PYTHONPATH"):
                value = re.search(rf'^declare -x {name}="(.*)"$', (self.home / "exported").read_text(), re.M)
                self.environment |= {name: value[1]} if value else {}

    def part(self, part):
        """Of parts(): commands are given, files saved."""
        kind, *rest = part
        if kind == "shell":
            self.give(rest[0])
        elif kind == "file":
            (self.place / rest[0]).write_text(rest[1])
            self.typed += rest[1]

    def page(self, text):
        for part in parts(text):
            self.part(part)
