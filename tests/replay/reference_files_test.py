#!/usr/bin/env python3
"""Replays every reference file of a folder; those of kinds that are not built are named, all others must agree.

    reference_files_test.py REFERENCE_REPLAY FOLDER        SKEIN_REFERENCE_DIR, where set, replaces FOLDER
"""
import os
import pathlib
import subprocess
import sys

NOT_BUILT = 7


def main():
    program, folder = sys.argv[1], pathlib.Path(os.environ.get("SKEIN_REFERENCE_DIR") or sys.argv[2])
    files = sorted(folder.glob("*.json"))
    if not files:
        sys.exit(f"no reference files in {folder}")
    failed, agree = [], 0
    for file in files:
        done = subprocess.run([program, str(file)], capture_output=True, text=True)
        print(done.stdout + done.stderr, flush=True)
        if done.returncode not in (0, NOT_BUILT):
            failed.append(f"{file.name} (exit code {done.returncode})")
        agree += done.returncode == 0
    print("do not agree: " + ", ".join(failed) if failed else f"all of {len(files)} files agree or are not built")
    return 1 if failed or not agree else 0


if __name__ == "__main__":
    sys.exit(main())
