"""The `pyport` command; `python -m pyport` is it too."""

import sys


def main() -> None:
    """Run the command line; the steering table, by the kernel, before anything is imported."""
    try:
        if sys.argv[1:2] == ["table"]:
            from pyport.pointing import compiled

            if compiled.answered(sys.argv[1:]):
                return
        from pyport import cli
    except KeyboardInterrupt:
        sys.stderr.write("pyport: interrupted\n")
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
