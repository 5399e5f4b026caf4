"""Timing diagrams of the datasheet, as SVG."""

import json

from tfra.codegen.package.contents import template


def waves() -> dict[str, str]:
    """Diagrams by their names, made of WaveDrom's signals in ``templates/waves.json``, to be put into a page."""
    import wavedrom

    diagrams = {}
    for name, signals in json.loads(template("waves.json")).items():
        svg = wavedrom.render(json.dumps({"signal": signals, "config": {"hscale": 2}})).tostring()
        diagrams[name] = str(svg[svg.index("<svg") :])
    return diagrams
