"""`python -m rankdrop`: the command line, where its script is not on the path."""

from rankdrop.cli.main import main

if __name__ == "__main__":
    main()
