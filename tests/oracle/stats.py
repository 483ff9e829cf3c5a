#!/usr/bin/env python3
"""Tails and quantiles of t and F by scipy: stats.py > stats.json (scipy 1.x)."""
import json
from scipy import stats

t = [{"t": x, "dof": d, "p": 2 * stats.t.sf(x, d)} for x in (0.1, 1.96, 3.2, 12.0) for d in (1, 2, 5, 57, 1e4, 1e5, 1e6, 1e7)]
tq = [{"level": q, "dof": d, "factor": stats.t.ppf(0.5 + q / 2, d)} for q in (0.5, 0.95, 0.999) for d in (1, 2, 5, 57, 1e4, 1e5, 1e6, 1e7)]
dofs = ((1, 3), (2, 57), (18, 57), (3, 1e4), (3, 1e5), (5, 1e6), (2, 1e7), (100, 1e5), (1000, 1e4))
f = [{"f": x, "dof": [a, b], "p": stats.f.sf(x, a, b)} for x in (0.3, 1.02, 2.5, 40.0) for a, b in dofs]
fq = [{"p": p, "dof": [a, b], "f": stats.f.ppf(1 - p, a, b)} for p in (0.5, 0.05, 0.01) for a, b in dofs]
print(json.dumps({"t_two_sided": t, "t_factor": tq, "f_tail": f, "f_exceeded": fq}, indent=0))
