"""Nothing that reads files carries out what is in them: no eval, exec, pickle or shell outside tests.

    readers_test.py ROOT

Forged programs are tried first, so that a test which finds nothing has looked.
"""

import ast
import re
import sys
from pathlib import Path

CALLS = {"eval", "exec", "compile", "__import__", "execfile"}
MODULES = {"pickle", "cPickle", "dill", "marshal", "shelve", "joblib", "cloudpickle"}
METHODS = {("os", "system"), ("os", "popen"), ("subprocess", "getoutput"), ("subprocess", "getstatusoutput"), ("yaml", "load"), ("yaml", "unsafe_load"),
           ("builtins", "eval"), ("builtins", "exec"), ("np", "loads"), ("code", "interact")}
C_CALLS = re.compile(r"(?:\bstd|(?<!\w))::system\s*\(|(?<![\w:&*>.])(?<![\w&*>] )(?:system|popen|wordexp)\s*\(")
PAGE_CALLS = re.compile(r"\b(eval|Function)\s*\(|setTimeout\s*\(\s*[\"'`]")
SHELL_CALLS = re.compile(r"(^|[;&|]\s*|\bthen\s+|\bdo\s+)(eval|source\s+<\()\s")


def in_python(text):
    """[(line, what)] of a program."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
            found += [(node.lineno, name) for name in names if name.split(".")[0] in MODULES]
        if not isinstance(node, ast.Call):
            continue
        f = node.func
        if isinstance(f, ast.Name) and f.id in CALLS:
            found.append((node.lineno, f.id))
        if isinstance(f, ast.Attribute) and isinstance(f.value, ast.Name) and (f.value.id, f.attr) in METHODS:
            found.append((node.lineno, f"{f.value.id}.{f.attr}"))
        for word in node.keywords:
            if word.arg in ("shell", "allow_pickle") and not (isinstance(word.value, ast.Constant) and word.value.value is False):
                found.append((node.lineno, word.arg))
    return found


def by_lines(pattern, text, comment):
    return [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1) if pattern.search(line.split(comment)[0])]


FORGED = {"eval": "x = eval(text, {'__builtins__': {}})", "exec": "exec(open(path).read())", "pickle": "from pickle import load", "os.system": "import os\nos.system(a)",
          "yaml.load": "import yaml\nyaml.load(f)", "shell": "subprocess.run(a, shell=True)", "allow_pickle": "np.load(f, allow_pickle=True)", "compile": "compile(text, '', 'eval')"}
for what, text in FORGED.items():
    assert [name for _, name in in_python(text)] == [what], text
assert all(by_lines(C_CALLS, line, "//") for line in ("  std::system(text);", "::system(text)", "if (system(text))", "f = popen(text, r)"))
assert not by_lines(C_CALLS, "Kind& Scene::system(a)", "//")
assert not by_lines(C_CALLS, "// system(x)", "//") and not by_lines(C_CALLS, "file_system(x)", "//")
assert by_lines(PAGE_CALLS, "eval(data)", "//") and by_lines(SHELL_CALLS, 'eval "$line"', "#")
assert not in_python("re.compile(text)") and not in_python("self.eval(x)")

root = Path(sys.argv[1])
files = [path for folder in ("python", "apps", "bench", "jobscripts", "docs", "src", "include", "cmake") for path in sorted((root / folder).rglob("*"))
         if path.suffix in (".py", ".cpp", ".hpp", ".h", ".html", ".sh", ".sbatch") and "build" not in path.relative_to(root).parts]
assert len(files) > 400, len(files)
told = []
for path in files:
    text = path.read_text()
    found = (in_python(text) if path.suffix == ".py" else by_lines(PAGE_CALLS, text, "//") if path.suffix == ".html"
             else by_lines(SHELL_CALLS, text, "#") if path.suffix in (".sh", ".sbatch") else by_lines(C_CALLS, text, "//"))
    told += [f"{path.relative_to(root)}:{line}: {what}" for line, what in found]
if told:
    sys.exit("what a file says may be carried out here:\n  " + "\n  ".join(told))
print(f"{len(files)} files")
