"""Entry point of `python -m stiction`."""

from stiction.cli import main

if __name__ == "__main__":
    main()
