"""What every report shares: tables, pages, numbers and colours.

    from tfra.report.html import Section, page, paragraph
    from tfra.report.table import Table

    used = Table("Resources", ("", "used", "available"), [("LUT", 1200, 43848), ("DSP", 16, None)])
    page("A core", [paragraph("1,200 LUT.", "answer")], [Section("resources", "Resources", [used.html()])])
    used.markdown()  # for the guide
    used.text()  # for a file, lines of at most 100 characters
    console.print(used.rich())  # for a terminal

``table.number`` and ``cell`` format single numbers, ``colours`` is the palette of all charts.
"""
