"""The installed module, on the files of a checkout: `python test_module.py`. Needs numpy alone."""
import csv, gzip, io, json, os, pathlib, re, subprocess, sys, tempfile, time

import numpy as np

import lostmotion as lm

ROOT = pathlib.Path(__file__).resolve().parents[3]
os.chdir(ROOT)
ROBOT = "configs/kuka-kr120-r2500-pro.yaml"
robot = lm.Robot.load(ROBOT)


def command(*arguments):
    return subprocess.run([sys.executable, "-m", "lostmotion", *map(str, arguments)], capture_output=True, text=True)


def test_forward_kinematics_is_that_of_the_command():
    xyz, rotation = robot.forward(np.array([[0, -90, 90, 0, 0, 0], [10, -80, 95, 20, 30, 40.0]]))
    assert xyz.shape == (2, 3) and rotation.shape == (2, 3, 3)
    told = json.loads(command("robot", "check", ROBOT, "--pose", "10,-80,95,20,30,40", "--json").stdout)
    assert np.abs(xyz[1] - told["poses"][2]["xyz_mm"]).max() < 1e-9
    assert np.abs(rotation[1] @ rotation[1].T - np.eye(3)).max() < 1e-12
    assert robot.axes[0] == "A1" and robot.units[0] == "deg" and robot.limits.shape == (6, 2)


def test_a_log_of_arrays_is_the_log_of_the_file():
    log = lm.Log.load("samples/static/single_axis_A1.csv.gz", robot)
    again = lm.Log.from_arrays(robot, log.commands, log.tcp_mm, log.t_s)
    assert len(again) == len(log) and np.allclose(again.tcp_mm, log.tcp_mm, rtol=0, atol=1e-9, equal_nan=True)
    with gzip.open("samples/static/single_axis_A1.csv.gz", "rt") as f:
        rows = list(csv.DictReader(line for line in f if not line.startswith("#")))
    assert np.abs(log.commands[:, 0] - [float(r["cmd_A1_deg"]) for r in rows]).max() < 1e-12


def test_the_figures_are_those_of_the_command_line():
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        log = lm.Log.load("samples/static/single_axis_A1.csv.gz", robot)
        gaps = lm.identify(robot, [log], kind="static")
        out = command("identify", "static", "--robot", ROBOT, "--log", "samples/static/single_axis_A1.csv.gz", "--output", work / "gaps.yaml")
        assert out.returncode == 0, out.stderr
        assert lm.Gaps.load(work / "gaps.yaml", robot).joints[0].to_dict() == gaps.joints[0].to_dict()
        assert abs(gaps.joints[0].half_gap_deg - 0.0028) < 3e-5
        assert "<svg" in gaps.page() and "iframe" in gaps._repr_html_()

        compensator = lm.fit(robot, gaps)
        compensator.save(work / "compensator.yaml")
        assert lm.Compensator.load(work / "compensator.yaml", robot).to_dict()["joints"] == compensator.to_dict()["joints"]

        with open("samples/circle/circle_program.csv") as f:
            rows = list(csv.reader(line for line in f if not line.startswith("#")))
        q = np.array([[float(v) for v in r[:6]] for r in rows[1:]])
        done = lm.rewrite(robot, compensator, q, tcp_speed_mm_s=1.5)
        assert len(done.q) == done.points + done.inserted and done.given.sum() == len(q)
        out = command("rewrite", "--robot", ROBOT, "--compensator", work / "compensator.yaml", "samples/circle/circle_program.csv",
                      "--speed-mm-s", "1.5", "--output", work / "out.csv", "--force")
        assert out.returncode == 0, out.stderr
        with open(work / "out.csv") as f:
            written = [r for r in csv.reader(line for line in f if not line.startswith("#"))]
        written = np.array([[float(v) for v in r[:6]] for r in written[1:]])
        assert written.shape == done.q.shape and np.abs(written - done.q).max() < 1e-6


def test_simulate_and_diagnose():
    log = lm.Log.load("samples/static/single_axis_A1.csv.gz", robot)
    seen = lm.simulate("samples/models/kuka-table3.model.yaml", log=log)
    assert seen.tcp_mm.shape == (len(log), 3) and np.array_equal(seen.commands, log.commands)
    found = lm.diagnose([log], robot=robot)
    assert found.verdict in ("named", "named_set", "unknown", "none")
    assert any(e.target == "A1" for e in found.effects) and "lostmotion/model/1" in found.model


def test_join():
    joined = lm.join(robot, "samples/join/controller_2.csv.gz", "samples/join/tracker_2.csv.gz")
    truth = json.loads(pathlib.Path("samples/join/truth_2.json").read_text())
    want = (truth["offset_s"] + (truth["rate"] - 1) * joined.at_tracker_s) * 1e3
    assert abs(joined.offset_ms.value - want) < 0.3
    assert len(joined.columns["x_mm"]) == joined.rows


def test_refusals_are_exceptions_with_the_same_words():
    for call, words in [
        (lambda: lm.Robot.parse("schema: lostmotion/robot/1\njoints: [{name: A, kind: rotary}]\n"), "rotary"),
        (lambda: robot.forward(np.zeros((1, 5))), "expected 6"),
        (lambda: lm.Log.load("nowhere.csv", robot), "nowhere.csv"),
        (lambda: lm.run(["robot", "check", "nowhere.yaml"]), "nowhere.yaml"),
        (lambda: lm.run(["no-such-command"]), "no-such-command"),
    ]:
        try:
            call()
        except lm.BadInput as e:
            assert words in str(e), e
        else:
            raise AssertionError(words)
    out = command("robot", "check", "nowhere.yaml")
    assert out.returncode == 2 and out.stderr.startswith("lostmotion: nowhere.yaml")


def test_the_notebook_runs():
    cells = json.loads((pathlib.Path(__file__).parent.parent / "examples/notebook.ipynb").read_text())["cells"]
    code = ["".join(c["source"]) for c in cells if c["cell_type"] == "code"]
    assert len(code) >= 5
    names = {}
    for cell in code:
        exec(compile(cell, "notebook", "exec"), names)


def measure():
    """Import time in a fresh interpreter, and the time of reading 262,000 rows against the command that reads them."""
    tries = [f"import time; t = time.perf_counter(); import {m}; print(time.perf_counter() - t)" for m in ("numpy", "lostmotion")]
    spent = [min(float(subprocess.run([sys.executable, "-c", t], capture_output=True, text=True).stdout) for _ in range(5)) for t in tries]
    print(f"import: {1e3 * spent[1]:.0f} ms, of which numpy {1e3 * spent[0]:.0f} ms")


if __name__ == "__main__":
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            begun = time.perf_counter()
            test()
            print(f"{name}: {time.perf_counter() - begun:.2f} s")
    measure()
