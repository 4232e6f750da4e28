"""`python -m gonio`: the command line where its script is not on the path, as on some Windows machines."""

from gonio.cli import main

if __name__ == "__main__":
    main(prog_name="gonio")
