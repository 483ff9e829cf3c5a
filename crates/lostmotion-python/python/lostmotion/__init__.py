"""Lost motion (backlash and stiction) out of robot programs, before they reach the controller.

The engine and the figures are those of the command `lostmotion`. Angles are degrees, lengths millimetres, times seconds; joint arrays
have one row a sample and one column an axis. Refusals are exceptions with the words of the command line: `BadInput` and `Refused`.
"""
from __future__ import annotations

import csv as _csv
import html as _html
import io as _io
import json as _json
import os as _os

from . import _native
from ._native import BadInput, Log, LostMotionError, Refused, Robot, __version__

__all__ = [
    "BadInput", "Compensator", "Diagnosis", "Gaps", "Joined", "Log", "LostMotionError", "Refused", "Result", "Rewritten", "Robot",
    "Simulated", "__version__", "diagnose", "fit", "identify", "join", "rewrite", "run", "simulate",
]


class Result:
    """A document of lostmotion: its keys are attributes, `to_dict()` is the whole."""

    def __init__(self, document):
        self._document = document

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _wrapped(self._document[name])
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has {', '.join(self._document)}; not {name}") from None

    def __dir__(self):
        return [*super().__dir__(), *self._document]

    def __eq__(self, other):
        return isinstance(other, Result) and self._document == other._document

    def to_dict(self):
        return self._document

    def __repr__(self):
        return f"<lostmotion.{type(self).__name__} {', '.join(self._document)}>"


def _wrapped(value):
    if isinstance(value, dict):
        return Result(value)
    if isinstance(value, list):
        return [_wrapped(v) for v in value]
    return value


def _framed(page):
    """A whole page in a cell of a notebook: its style and script stay inside."""
    return f'<iframe srcdoc="{_html.escape(page, quote=True)}" style="width:100%;height:640px;border:0"></iframe>'


class Gaps(Result):
    """What `identify` found; `joints`, `points`, `registration`, ... as in the document lostmotion/gaps/1."""

    def __init__(self, native):
        super().__init__(_json.loads(native.json()))
        self._native = native

    @classmethod
    def load(cls, path, robot):
        return cls(_native.Gaps.load(_os.fspath(path), robot))

    def to_yaml(self):
        return self._native.yaml()

    def save(self, path):
        _write(path, self.to_yaml())

    def page(self):
        return self._native.page()

    def _repr_html_(self):
        return _framed(self.page())


class Compensator(Result):
    """Offsets by joint, as in the document lostmotion/compensator/1."""

    def __init__(self, native):
        super().__init__(_json.loads(native.json()))
        self._native = native

    @classmethod
    def load(cls, path, robot):
        return cls(_native.Compensator.load(_os.fspath(path), robot))

    @classmethod
    def of_model(cls, path):
        return cls(_native.Compensator.of_model(_os.fspath(path)))

    def to_yaml(self):
        return self._native.yaml()

    def save(self, path):
        _write(path, self.to_yaml())

    def page(self):
        return self._native.page()

    def _repr_html_(self):
        return _framed(self.page())


class Diagnosis(Result):
    """What a model lacks, as in the document lostmotion/diagnosis/1; `model` is the model with what was found, as YAML."""

    def __init__(self, document, page, model):
        super().__init__(document)
        self._page, self._model = page, model

    @property
    def model(self):
        return self._model

    def save_model(self, path):
        _write(path, self._model)

    def page(self):
        return self._page

    def _repr_html_(self):
        return _framed(self._page)


class Rewritten:
    """A path with offsets and new points. `q`: positions; `given[i]`: row i is one of the path's own points."""

    def __init__(self, fields):
        self.__dict__.update(fields)

    def __len__(self):
        return len(self.q)

    def __repr__(self):
        return f"<lostmotion.Rewritten {self.points} points, {self.inserted} new, reversals {self.reversals}>"

    def _repr_html_(self):
        cells = "".join(f"<td>{n}</td>" for n in self.reversals)
        return (f"<table><tr><th>points</th><td>{self.points}</td></tr><tr><th>new points</th><td>{self.inserted}</td></tr>"
                f"<tr><th>reversals by axis</th>{cells}</tr>"
                f"<tr><th>largest change of the path</th><td>{self.largest_change_um:.1f} &micro;m</td></tr></table>")


class Simulated:
    """What a tracker sees: `t_s`, `commands` and `tcp_mm`, row by row."""

    def __init__(self, t_s, commands, tcp_mm):
        self.t_s, self.commands, self.tcp_mm = t_s, commands, tcp_mm

    def __len__(self):
        return len(self.t_s)

    def __repr__(self):
        return f"<lostmotion.Simulated {len(self)} rows>"


class Joined(Result):
    """Two recordings on one clock, as in the document lostmotion/join/1; `csv` is the log, `columns` its arrays by name."""

    def __init__(self, document, csv):
        super().__init__(document)
        self._csv = csv

    @property
    def csv(self):
        return self._csv

    @property
    def columns(self):
        import numpy as _np

        rows = list(_csv.reader(_io.StringIO(self._csv.decode())))
        values = _np.array([[float(v) if v else _np.nan for v in row] for row in rows[1:]])
        return {name: values[:, k] for k, name in enumerate(rows[0])}

    def save(self, path):
        _write(path, self._csv.decode())


def _write(path, text):
    with open(path, "w", encoding="utf-8", newline="") as f:
        f.write(text)


def _array(values):
    import numpy as _np  # here, as importing it takes ten times as long as importing this module

    return _np.ascontiguousarray(values, dtype=_np.float64)


def identify(robot, logs, kind="machine"):
    """Gaps and friction of the joints. `kind`: `machine` (all logs together), `static` or `path`."""
    if kind not in ("machine", "static", "path"):
        raise BadInput(f"kind {kind!r}; expected machine, static or path")
    return Gaps(_native.identify(robot, list(logs), kind))


def fit(robot, gaps):
    """A compensator of gaps."""
    return Compensator(_native.fit(robot, [g._native for g in ([gaps] if isinstance(gaps, Gaps) else gaps)]))


def rewrite(robot, compensator, q, t_s=None, tcp_speed_mm_s=None, gain=1.0):
    """A path (rows of joint positions) with reversal points and offsets. Whole programs: `run(["rewrite", ...])`."""
    t_s = None if t_s is None else _array(t_s)
    return Rewritten(_native.rewrite(robot, compensator._native, _array(q), t_s, tcp_speed_mm_s, gain))


def simulate(model, log=None, program=None, rate_hz=25.0, tcp_speed_mm_s=1.5):
    """What a tracker would see of a log's commands, or of a program's, on the machine of a model file."""
    program = None if program is None else _os.fspath(program)
    return Simulated(*_native.simulate(_os.fspath(model), log, program, rate_hz, tcp_speed_mm_s))


def diagnose(logs, model=None, robot=None):
    """What a model (a file) or an ideal robot lacks to explain logs."""
    model = None if model is None else _os.fspath(model)
    document, page, found = _native.diagnose(list(logs), model, robot)
    return Diagnosis(_json.loads(document), page, found)


def join(robot, controller, tracker, controller_columns=None, tracker_columns=None, near_s=None):
    """A controller's and a tracker's recordings on one clock."""
    paths = [None if p is None else _os.fspath(p) for p in (controller, tracker, controller_columns, tracker_columns)]
    document, csv = _native.join(robot, *paths, near_s)
    return Joined(_json.loads(document), csv)


def run(arguments):
    """A command, as on the command line without the program's name: `run(["rewrite", "--robot", ...])`."""
    _native.run([_os.fspath(a) for a in arguments])
