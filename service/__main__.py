"""`python -m service`: what `camwright serve` does, with its options."""

import typer

from service.commands.serve import serve

if __name__ == "__main__":
    typer.run(serve)
