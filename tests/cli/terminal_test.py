"""What a terminal and a shell see: help, progress, Ctrl-C, man page, completion."""
import json
import os
import pty
import re
import select
import signal
import subprocess
import time
import unittest

from program import MESHES, PROGRAM, SLOWNESS, ProgramTest

TREE = MESHES / "tree.obj"
LONG = ("mesh", TREE, "--voxels", "512", "--cells", "256", "--smoothing-iterations", "20")


class Progress(ProgramTest):
    def test_a_line_a_phase_where_there_is_no_terminal(self):
        done = self.run_program("mesh", MESHES / "sphere.obj", "--voxels", "32", "--cells", "8")
        lines = done.stderr.decode().splitlines()
        for phase in ("distance_field", "pseudo_volume", "smoothing"):
            self.assertEqual(lines.count(phase), 1, lines)
        self.assertEqual(done.stdout, b"")
        self.assertNotIn(b"\r", done.stderr)
        self.assertEqual(self.run_program("mesh", MESHES / "sphere.obj", "--voxels", "32", "--cells", "8",
                                          "-q").stderr, b"")

    def test_a_line_a_case_of_the_stability_suite_beside_its_document(self):
        child = subprocess.Popen([PROGRAM, "stability", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        while line := child.stderr.readline():
            if line.startswith((b"ok ", b"FAIL ")):
                break
        child.send_signal(signal.SIGINT)
        out, _ = child.communicate(timeout=120 * SLOWNESS)
        self.assertEqual(child.returncode, 130)
        self.assertIn(json.loads(out)["cases"][0]["name"], line.decode())

    def test_a_bar_on_a_terminal(self):
        main, side = pty.openpty()
        child = subprocess.Popen([PROGRAM, "mesh", str(TREE), "--json"], stderr=side, stdout=subprocess.PIPE)
        os.close(side)
        drawn = b""
        while True:
            try:
                data = os.read(main, 4096)
            except OSError:
                break
            if not data:
                break
            drawn += data
        json.loads(child.stdout.read())
        child.stdout.close()
        self.assertEqual(child.wait(), 0)
        os.close(main)
        self.assertRegex(drawn, rb"\r\x1b\[K\[#+\.*\] +\d+ % distance_field")


class Interrupt(ProgramTest):
    def interrupted(self, after, signal_number):
        child = subprocess.Popen([PROGRAM, *map(str, LONG), "-o", str(self.folder / "out.msh"), "--json"],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        child.stderr.readline()  # until it has begun
        time.sleep(after)
        child.send_signal(signal_number)
        out, error = child.communicate(timeout=120 * SLOWNESS)
        return child.returncode, out, error

    def test_cancels_cleanly(self):
        for after, number in ((0.5, signal.SIGINT), (1.0, signal.SIGTERM), (2.0, signal.SIGINT)):
            with self.subTest(after):
                code, out, error = self.interrupted(after, number)
                self.assertEqual(code, 130, error)
                self.assertEqual(json.loads(out)["code"], "cancelled")
                self.assert_files()

    def test_what_was_there_stays(self):
        self.file("out.msh", "old")
        self.assertEqual(self.interrupted(0.5, signal.SIGINT)[0], 130)
        self.assertEqual((self.folder / "out.msh").read_text(), "old")
        self.assert_files("out.msh")


class Documentation(ProgramTest):
    def test_help_and_version(self):
        self.assertRegex(self.run_program("--version").stdout, rb"^isochor \d+\.\d+\.\d+\n$")
        text = self.run_program("--help").stdout.decode()
        for command in ("serve", "mesh", "simulate", "info", "formats"):
            self.assertIn(command, text)
        self.assertNotIn("generate", text)
        self.assertIn("--p-subs-voxels", self.run_program("mesh", "--help").stdout.decode())

    def test_every_parameter_is_an_option(self):
        params = self.run_json("mesh", MESHES / "cube.obj", "--voxels", "16", "--cells", "4")["params"]
        text = self.run_program("mesh", "--help").stdout.decode()
        for name in [*params, "p_in", "p_subs"]:
            self.assertIn("--" + name.replace("_", "-"), text)

    def test_the_man_page_is_sound_roff(self):
        page = self.run_program("generate", "man").stdout
        done = subprocess.run(["groff", "-man", "-Tutf8", "-ww"], input=page, capture_output=True)
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        text = re.sub(rb"\x1b\[\d+m|.\x08", b"", done.stdout).decode()
        for word in ("NAME", "MESH", "--smoothing-iterations", "EXIT STATUS"):
            self.assertIn(word, text)

    def test_completion_by_bash(self):
        script = self.file("completion.bash", self.run_program("generate", "bash-completion").stdout.decode())

        def complete(*words):
            code = (f"source {script}; COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}; _isochor; "
                    'echo "${COMPREPLY[@]}"')
            return subprocess.run(["bash", "-c", code], capture_output=True, check=True).stdout.decode().split()

        self.assertEqual(complete("isochor", "me"), ["mesh"])
        self.assertEqual(complete("isochor", "mesh", "--smoothing-i"), ["--smoothing-iterations"])
        self.assertIn("--encoding", complete("isochor", "simulate", "--"))

    def test_completion_by_zsh(self):
        self.file("_isochor", self.run_program("generate", "zsh-completion").stdout.decode())
        main, side = pty.openpty()
        shell = subprocess.Popen(["zsh", "-f", "-i"], stdin=side, stdout=side, stderr=side, start_new_session=True,
                                 cwd=self.folder, env={"TERM": "dumb", "PATH": os.environ["PATH"], "LC_ALL": "C.UTF-8"})
        os.close(side)

        def await_shown(*expected):
            shown, end = b"", time.monotonic() + 120 * SLOWNESS
            while not all(text in shown for text in expected) and time.monotonic() < end:
                if select.select([main], [], [], 0.2)[0]:
                    shown += os.read(main, 65536)
            for text in expected:
                self.assertIn(text, shown)

        def complete(line, *expected):
            """All of that stands on the terminal after a tab."""
            os.write(main, line.encode() + b"\t")
            await_shown(*expected)
            os.write(main, b"\x15")  # Ctrl-U

        os.write(main, b"PROMPT='> '; fpath=($PWD $fpath); autoload -U compinit; compinit -u -D; print ready $((1 + 1))\n")
        await_shown(b"ready 2")
        complete("isochor me", b"isochor mesh ")
        complete("isochor mesh --smoothing-i", b"--smoothing-iterations")
        complete("isochor simulate --en", b"--encoding")
        complete("isochor ", b"formats", b"simulate", b"serve")
        os.write(main, b"exit\n")
        shell.wait(timeout=120 * SLOWNESS)
        os.close(main)
        os.remove(self.folder / "_isochor")


if __name__ == "__main__":
    unittest.main()
