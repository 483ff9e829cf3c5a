#!/usr/bin/env python3
"""Expected results of `simulate` and `assess circle`, from the simulated experiment (the twin) of Zhang (2023).

  python3 tests/oracle/twin_circle.py PATH/TO/twin.py

writes tests/data/twin/ again. The twin shares no code and no kinematic convention with lostmotion. It needs numpy, scipy
and pandas. Everything here is simulated; nothing was measured.

  run_<machine>.csv.gz     noise-free run of the circle program at 25 Hz, every 50th row, with encoder columns
  table3_program.csv       the circle program with the controller of Zhang (2023) Table 3, as printed (`--kind table3`)
  best_program.csv         the circle program compensated by the twin (`--kind best`)
  run_best.csv.gz          its noise-free run on machine table3, every 50th row
  static_A2_program.csv    Zhang (2023)'s static test of A2 as a program with times
  static_A2.csv.gz         its noise-free run at 2 Hz on machine figure5 without stiction, all rows
  log_<name>.csv.gz        runs at 5 Hz with 11 um noise: table3, figure5, best (machine table3)
  score_<name>.json        `twin.py score` of these logs
"""
import argparse, gzip, importlib.util, json, pathlib, sys
import numpy as np

spec = importlib.util.spec_from_file_location("twin", sys.argv[1])
twin = importlib.util.module_from_spec(spec)
spec.loader.exec_module(twin)
OUT = pathlib.Path(__file__).resolve().parent.parent / "data" / "twin"
OUT.mkdir(parents=True, exist_ok=True)


def options(**given):
    o = dict(speed_mm_s=twin.SPEED, rate=25, machine="table3", stiction="stick", noise_um=0.0, seed=1,
             base_frame=False, encoders=False)
    return argparse.Namespace(**{**o, **given})


def decimate(path, every):
    with gzip.open(path, "rt") as f:
        lines = f.read().splitlines(keepends=True)
    body = lines[2:]
    text = "".join([lines[0].rstrip("\n") + f"; every {every}th row\n", lines[1]] + body[::every])
    with open(path, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as f:
        f.write(text.encode())


circle = twin.circle()
for machine in ("table3", "figure5"):
    path = OUT / f"run_{machine}.csv.gz"
    twin.run(circle, None, path, options(machine=machine, encoders=True), f"twin, circle, {machine}, noise-free")
    decimate(path, 50)
twin.write_program(OUT / "table3_program.csv", twin.compensate(circle, "table3"))
best = twin.compensate(circle, "best")
twin.write_program(OUT / "best_program.csv", best)
best, _ = twin.read_program(OUT / "best_program.csv")
twin.run(best, None, OUT / "run_best.csv.gz", options(), "twin, circle compensated (best), table3, noise-free")
decimate(OUT / "run_best.csv.gz", 50)

# the static test of A2: vertices and times as twin.static lays them out
kept = {}
execute = twin.execute
twin.execute = lambda cmd, tv, *a: kept.update(cmd=cmd, tv=tv) or execute(cmd, tv, *a)
twin.static("A2", OUT / "static_A2.csv.gz", rate=2, noise_um=0.0)
twin.execute = execute
head = "t_s," + ",".join(f"a{i}_deg" for i in range(1, 7)) + "\n"
rows = ["%.12f," % t + ",".join("%.6f" % x for x in q) + "\n" for t, q in zip(kept["tv"], kept["cmd"])]
(OUT / "static_A2_program.csv").write_text(head + "".join(rows))

circle_csv = OUT / "circle.csv"
twin.write_program(circle_csv, circle)
for name, q, machine in (("table3", circle, "table3"), ("figure5", circle, "figure5"), ("best", best, "table3")):
    path = OUT / f"log_{name}.csv.gz"
    twin.run(q, None, path, options(rate=5, machine=machine, noise_um=11.0), f"twin, {name}, 5 Hz, noise 11 um")
    (OUT / f"score_{name}.json").write_text(json.dumps(twin.score(path, circle_csv), indent=1) + "\n")
circle_csv.unlink()
