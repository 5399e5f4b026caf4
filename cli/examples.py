"""``tfra examples``: files to start from."""

import difflib
from pathlib import Path
from typing import Annotated

import typer

from tfra.runtime.errors import InputError, quoted

Name = Annotated[str | None, typer.Argument(metavar="NAME", help="An example; without --out, print its text.")]
Out = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="Write all examples, or NAME and the files it reads, to this new or empty directory."
    ),
]


def examples(name: Name = None, out: Out = None) -> None:
    """List the example CONFIG and STUDY files and the recording, print one, or write them to a directory."""
    from tfra.codegen.config.examples import examples as known
    from tfra.codegen.config.examples import title, write_examples

    texts = known()
    chosen = None if name is None else name.removesuffix(".toml")
    if chosen is not None and chosen not in texts:
        nearest = difflib.get_close_matches(chosen[:60], texts, n=1, cutoff=0)[0]
        raise InputError("tfra examples", "NAME", f"no example {quoted(name)}, the nearest is {nearest}")
    if out:
        written = write_examples(out, list(texts) if chosen is None else [chosen])
        typer.echo(f"{out}: {', '.join(written)}")
    elif chosen is None:
        width = max(map(len, texts))
        for each, text in texts.items():
            typer.echo(f"{each:{width}}  {title(text)}")
    else:
        typer.echo(texts[chosen], nl=False)
