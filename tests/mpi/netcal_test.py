"""netcal_test.py MPIEXEC NETCAL: the machine file has the keys that a plan reads, and its figures describe the times measured."""
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

mpiexec, netcal = sys.argv[1:]


def start(ranks, *options):
    return subprocess.run([mpiexec, "-n", str(ranks), netcal, *options], capture_output=True, text=True, timeout=200)


with tempfile.TemporaryDirectory() as scratch:
    for ranks in 2, 3:
        file = pathlib.Path(scratch, f"machine_{ranks}.toml")
        done = start(ranks, "--threads", "1", "--batches", "5", "--out", file)
        assert done.returncode == 0, done.stdout + done.stderr
        told = tomllib.loads(file.read_text())
        assert list(told) == ["network", "machine"], list(told)
        network, machine = told["network"], told["machine"]
        for table in network, machine:
            for key, value in table.items():
                for number in value if isinstance(value, list) else [value]:
                    assert isinstance(number, str) or (number > 0 and math.isfinite(number)), f"{key} = {value}"
        assert (machine["ranks"], machine["ranks_per_node"], machine["nodes"], machine["threads_per_rank"]) == (ranks, ranks, 1, 1), machine
        assert machine["cores_per_node"] <= os.cpu_count(), machine

        # Latency is the time of the least message, and misfit how far the line is from any time: to 4 digits, as the file has them.
        sizes, times = network["message_bytes"], network["message_s"]
        assert sizes[0] == 8 and sizes[-1] == 8 << 20 and sizes == sorted(sizes), sizes
        assert times[0] == network["latency_s"]
        ratios = [t / (network["latency_s"] + n / network["bandwidth_B_per_s"]) for n, t in zip(sizes, times)]
        misfit = max(max(ratios), 1 / min(ratios))
        assert abs(misfit / network["misfit"] - 1) < 0.01, (ratios, network["misfit"])
        # No other bandwidth fits better.
        for factor in 0.9, 1.1:
            others = [t / (network["latency_s"] + n / (factor * network["bandwidth_B_per_s"])) for n, t in zip(sizes, times)]
            assert max(max(others), 1 / min(others)) > 0.999 * misfit, (factor, misfit)

    alone = start(1, "--out", pathlib.Path(scratch, "alone.toml"))
    assert alone.returncode == 2 and "two ranks are needed" in alone.stderr, alone.stderr
    nowhere = start(2, "--batches", "1", "--threads", "1", "--out", pathlib.Path(scratch, "none", "machine.toml"))
    assert nowhere.returncode == 5 and "machine.toml" in nowhere.stderr, nowhere.stderr
print("machine files of 2 and 3 ranks hold together")
