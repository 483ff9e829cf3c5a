"""The program `lostmotion`."""
import sys

from ._native import main as _main


def main():
    sys.exit(_main(["lostmotion", *sys.argv[1:]]))
