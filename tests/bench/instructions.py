#!/usr/bin/env python3
"""Instructions of a frame of a cube of 8³ cells, by valgrind: the step written by hand with nothing in it but what the
scene needs, the same by the scene's stepper, and with one feature more each: instructions.py COUNT_STEP [--json].
Start and end are left out by counting a long and a short run. The first two must end at the same bits."""
import json
import re
import subprocess
import sys

SCENES = ("by_hand", "plain", "gravity", "diagonals", "damping", "a_rigid_body_far_away", "one_with_a_mass_far_away",
          "self_contact")
SHORT, LONG = 2, 6  # frames


def counted(program, scene, frames):
    """Instructions, and the hash of where the particles are."""
    command = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, scene, str(frames))
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1]), done.stdout.strip()


def measure(program):
    frames, ends = {}, {}
    for scene in SCENES:
        (few, _), (many, ends[scene]) = counted(program, scene, SHORT), counted(program, scene, LONG)
        frames[scene] = (many - few) / (LONG - SHORT)
    if ends["plain"] != ends["by_hand"]:
        sys.exit("the stepper and the step by hand end at different places: they do not count the same work")
    return {scene: {"instructions": round(count), "over_by_hand": round(count / frames["by_hand"], 4)}
            for scene, count in frames.items()}


def main():
    figures = measure(sys.argv[1])
    if "--json" in sys.argv:
        return print(json.dumps(figures, indent=1))
    for scene, figure in figures.items():
        print(f"{scene:<28}{figure['instructions']:>14,}{figure['over_by_hand']:>10.4f}")


if __name__ == "__main__":
    main()
