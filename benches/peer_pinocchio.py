#!/usr/bin/env python3
"""Pinocchio beside `cargo bench --bench kinematics`: TCP position and Jacobian of a six-axis arm, ns a configuration.

Needs `pip install pin` (3.x or 4.x), numpy, pyyaml. Every call gets preallocated arguments; what Python itself costs is
measured as a call of the same binding on a model without joints. `peer_pinocchio.cpp` is the same loop without Python.

  peer_pinocchio.py [robot.yaml]
"""
import pathlib, sys, time
import numpy as np
import pinocchio as pin
import yaml

HERE = pathlib.Path(__file__).parent


def rot(axis, deg):
    c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) if axis == "x" else np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def model_of(path):
    """A Pinocchio model of a robot file with standard DH and revolute joints; the TCP is the last frame."""
    f = yaml.safe_load(open(path))
    assert f.get("convention", "dh-standard") == "dh-standard" and all(j["kind"] == "revolute" for j in f["joints"])
    m, parent, place = pin.Model(), 0, pin.SE3.Identity()
    for j in f["joints"]:
        axis = pin.JointModelRZ() if j["direction"] > 0 else pin.JointModelRevoluteUnaligned(0, 0, -1)
        # the constant part of theta turns before the joint
        parent = m.addJoint(parent, axis, place * pin.SE3(rot("z", j["theta_deg"]), np.zeros(3)), j["name"])
        alpha = pin.SE3(rot("x", j["alpha_deg"]), np.zeros(3))
        place = pin.SE3(np.eye(3), np.array([j["a_mm"], 0, j["d_mm"]]) * 1e-3) * alpha
    tool = pin.SE3(np.eye(3), np.array(f["tool"]["xyz_mm"]) * 1e-3)
    frame = m.addFrame(pin.Frame("tcp", parent, 0, place * tool, pin.FrameType.OP_FRAME))
    return m, frame


def best(f, qs, repeats=15):
    times = []
    for _ in range(repeats):
        t = time.perf_counter()
        for q in qs:
            f(q)
        times.append(time.perf_counter() - t)
    return np.median(times) / len(qs) * 1e9


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else HERE.parent / "configs" / "kuka-kr120-r2500-pro.yaml"
    m, frame = model_of(path)
    d = m.createData()
    n = 20000
    qs = list(np.sin((np.arange(n)[:, None] * 7 + np.arange(m.nq) * 13) * 0.017))
    out = np.zeros((6, m.nv))
    ref = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    p = d.oMf[frame].translation

    def frame_jacobian(q):
        pin.computeFrameJacobian(m, d, q, frame, ref)

    def joint_jacobians(q):
        pin.computeJointJacobians(m, d, q)

    def jacobians_and_frame(q):
        pin.computeJointJacobians(m, d, q)
        pin.updateFramePlacement(m, d, frame)
        pin.getFrameJacobian(m, d, frame, ref)

    bare = pin.Model()
    bare_data, none = bare.createData(), np.zeros(0)
    print(f"pinocchio {pin.__version__}, {path}")
    print(f"python and binding alone (model without joints)   {best(lambda q: pin.computeJointJacobians(bare, bare_data, none), qs):8.0f} ns")
    for name, f in [("computeJointJacobians", joint_jacobians), ("computeFrameJacobian", frame_jacobian),
                    ("computeJointJacobians + placement + getFrameJacobian", jacobians_and_frame)]:
        print(f"{name:50s}{best(f, qs):8.0f} ns")


if __name__ == "__main__":
    main()
