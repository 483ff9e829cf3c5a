"""Writes tests/data/ros2.mcap: joint states and poses as a ROS 2 recorder stores them, by the MCAP and ROS 2 writers of their makers.

usage: python tests/oracle/bag.py        (needs mcap and mcap-ros2-support from PyPI)

200 joint states at 100 Hz and 100 poses at 50 Hz (stamped 0.25 s later by a clock of their own), closed-form values:
base = 0.3 sin(t), elbow = -0.5 + 0.2 t (rad); effort of base 12.5 cos(t) N m;
x = 0.8 + 0.01 t, y = -0.2, z = 0.05 t (m), turned by 30 degrees about z. Chunks are packed with Zstandard.
"""
import math
import pathlib
from mcap_ros2.writer import Writer

STAMP = "builtin_interfaces/Time stamp\nstring frame_id\n"
HEADER = "================================================================================\nMSG: std_msgs/Header\n" + STAMP
TIME = "================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
JOINTS = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" + HEADER + TIME
POSE = (
    "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + HEADER + TIME
    + "================================================================================\nMSG: geometry_msgs/Pose\n"
    "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
    "================================================================================\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
)


def stamp(ns):
    return {"sec": ns // 10**9, "nanosec": ns % 10**9}


def main():
    path = pathlib.Path(__file__).parents[1] / "data" / "ros2.mcap"
    start = 1_700_000_000_123_456_789
    with open(path, "wb") as f:
        writer = Writer(f)
        joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
        pose = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE)
        for k in range(200):
            ns = start + k * 10**7
            t = k / 100
            writer.write_message(
                topic="/joint_states", schema=joints, log_time=ns + 500, publish_time=ns,
                message={
                    "header": {"stamp": stamp(ns), "frame_id": "base_link"},
                    "name": ["base", "elbow"],
                    "position": [0.3 * math.sin(t), -0.5 + 0.2 * t],
                    "velocity": [],
                    "effort": [12.5 * math.cos(t), 0.0],
                },
            )
            if k % 2 == 0:
                writer.write_message(
                    topic="/tracker/pose", schema=pose, log_time=ns + 900, publish_time=ns,
                    message={
                        "header": {"stamp": stamp(ns + 250_000_000), "frame_id": "tracker"},
                        "pose": {
                            "position": {"x": 0.8 + 0.01 * t, "y": -0.2, "z": 0.05 * t},
                            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(math.radians(15)), "w": math.cos(math.radians(15))},
                        },
                    },
                )
        writer.finish()


if __name__ == "__main__":
    main()
