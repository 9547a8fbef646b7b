#!/usr/bin/env python3
"""One JSON from what the benchmarks wrote: collect.py [--into] OUT PART… Of Google Benchmark's fields only those that say
something about the code are kept. --into keeps the other programs of OUT, which must be of this machine, compiler and
commit."""
import json
import os
import pathlib
import subprocess
import sys

NOISE = {"family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index", "threads",
         "aggregate_unit"}


def first_line(*command):
    done = subprocess.run(command, cwd=pathlib.Path(__file__).parent, capture_output=True, text=True)
    return done.stdout.splitlines()[0].strip() if done.stdout else "unknown"


def rounded(value):
    return float(f"{value:.4g}") if isinstance(value, float) else value


def entry(benchmark):
    return {name: rounded(value) for name, value in benchmark.items() if name not in NOISE}


def program(document):
    return [entry(benchmark) for benchmark in document["benchmarks"]] if "benchmarks" in document else document


def lines(item):
    """A program, one benchmark a line."""
    name, entries = item
    text = "[" + ",\n".join(map(json.dumps, entries)) + "]" if isinstance(entries, list) else json.dumps(entries)
    return f"{json.dumps(name)}: {text}"


def earlier(out, figures):
    """The programs that stand in OUT already."""
    if not os.path.exists(out):
        return {}
    known = json.load(open(out))
    for name in ("machine", "compiler", "commit"):
        if known[name] != figures[name]:
            sys.exit(f"{out} has another {name}: {known[name]}, not {figures[name]}; run all programs")
    return known["programs"]


def main(out, *parts, into=False):
    cpu = [line.split(": ", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    figures = {"machine": f"{cpu[0] if cpu else 'unknown CPU'}, {os.cpu_count()} cores",
               "compiler": first_line("c++", "--version"), "commit": first_line("git", "rev-parse", "--short=12", "HEAD"),
               "load_average": round(os.getloadavg()[2], 1)}
    programs = earlier(out, figures) if into else {}
    programs.update({pathlib.Path(part).stem: program(json.load(open(part))) for part in parts})
    head = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in figures.items()]
    with open(out, "w") as file:
        file.write("{" + ",\n".join([*head, '"programs": {' + ",\n".join(map(lines, sorted(programs.items())))]) + "}}\n")


arguments = sys.argv[1:]
main(*(argument for argument in arguments if argument != "--into"), into="--into" in arguments)
