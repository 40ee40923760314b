"""The former place of `agents.export`."""

from agents.export import EXAMPLE, TOLERANCE, ExportedPolicy, export, largest_difference, main

__all__ = ["EXAMPLE", "TOLERANCE", "ExportedPolicy", "export", "largest_difference", "main"]

if __name__ == "__main__":
    raise SystemExit(main())
