#!/usr/bin/env python3
"""Looks through the program that no instruction of a level stands outside that level's kernels (cmake/SkeinKernels.cmake).

    levels_test.py OBJDUMP SKEIN KERNELS...

KERNELS are the joined objects of the levels; functions that they call elsewhere take no packs. Every level must be found where it belongs, so that a test which finds nothing elsewhere has looked.

Code of the baseline has fused multiply-adds of one number and of two lanes, of a higher level, in functions that ask the processor for them (`fma_of_one`, `fma_of_two`).
"""
import re
import subprocess
import sys

LEVELS = {"skein_x86_64": 0, "skein_x86_64_v3": 1, "skein_x86_64_v4": 2}  # section: level of its code; all others are of level 0
LINE = re.compile(r"^\s*[0-9a-f]+:\t(\S+)[ \t]*([^#<]*)")
NOT_VECTORS = {"verr", "verw", "vmcall", "vmlaunch"}


def level_of(mnemonic, operands):
    """0: any x86-64 has it; 1: AVX, AVX2, FMA; 2: AVX-512."""
    if re.search(r"%zmm|%[xyz]mm(1[6-9]|2\d|3[01])|%k[0-7]|\{", operands) or (mnemonic.startswith("kmov")):
        return 2
    return int(mnemonic.startswith("v") and mnemonic not in NOT_VECTORS)


def is_asked_for(mnemonic, operands):
    """True for fused multiply-adds of one number or two lanes, which the baseline runs where the processor has them."""
    return mnemonic in ("vfmadd213sd", "vfmadd213pd") and len(re.findall(r"%xmm(?:1[0-5]|\d)\b", operands)) == 3


assert is_asked_for("vfmadd213sd", "%xmm11,%xmm8,%xmm8") and is_asked_for("vfmadd213pd", "%xmm11,%xmm8,%xmm8") and not is_asked_for("vfmadd213pd", "%ymm1,%ymm8,%ymm8")
assert level_of("vpermilpd", "$0xb2,(%rdi),%zmm0") == 2 and level_of("vaddpd", "%ymm1,%ymm2,%ymm3") == 1
assert level_of("addpd", "%xmm1,%xmm2") == 0 and level_of("vmovsd", "%xmm0,8(%rax)") == 1

objdump, program, *kernels = sys.argv[1:]
found, wrong, section, function = {}, [], "", ""
fused, asking = set(), set()  # functions of the baseline with fused multiply-adds, and those that ask the processor
with subprocess.Popen([objdump, "-d", "--no-show-raw-insn", program], stdout=subprocess.PIPE, text=True) as listing:
    for line in listing.stdout:
        if line.startswith("Disassembly of section "):
            section = line.split()[-1].rstrip(":")
        elif line.endswith(">:\n"):
            function = line.split("<", 1)[1][:-3]
        elif instruction := LINE.match(line):
            level = level_of(*instruction.groups())
            if LEVELS.get(section, 0) == 0:
                if "<__cpu_model" in line:
                    asking.add(function.split(".")[0])
                if is_asked_for(*instruction.groups()):
                    fused.add(function.split(".")[0])
                    level = 0
            found[section] = max(level, found.get(section, 0))
            if level > LEVELS.get(section, 0):
                wrong.append(f"{section}, {function}: {line.strip()}")
assert not listing.returncode, objdump
built = [name for name in LEVELS if any(path.endswith(f"/{name}.o") for path in kernels)]
assert kernels and len(built) == len(kernels), kernels
assert fused or "skein_x86_64" not in built, "fused multiply-adds of the baseline"
wrong += [f"{name} does not ask the processor for its fused multiply-adds" for name in fused - asking]
for line in wrong[:10]:
    print(line)
for path in kernels:
    symbols = subprocess.run([objdump, "-t", path], capture_output=True, text=True, check=True).stdout
    wanted = {line.split()[-1] for line in symbols.splitlines() if "*UND*" in line}
    assert any("RodGroup" in name for name in wanted), path
    wrong += [f"{path} calls {name}, which is compiled for another level" for name in wanted if "4PackI" in name]
missing = [name for name in built if found.get(name) != LEVELS[name]]
if missing:
    print("sections without the instructions of their level:", ", ".join(missing))
if wrong or missing:
    sys.exit(f"{len(wrong)} instructions stand where older processors run")
print({name: level for name, level in found.items() if name in LEVELS or name == ".text"})
