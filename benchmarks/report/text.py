"""Numbers and tables as Markdown shows them."""


def number(x):
    if x is None:
        return "-"
    if x >= 1e200:
        return "not finite"
    if x == 0:
        return "0"
    return f"{x:.3g}" if 1e-3 <= abs(x) < 1e4 else f"{x:.1e}"


def ratio(x):
    if x == float("inf"):
        return "all"
    return f"{x:.3g}" if x < 1000 else f"{x:.0f}" if x < 1e4 else f"{x:.0e}"


def count(x):
    """A whole number with its thousands apart."""
    return f"{round(x):,}"


def table(head, rows):
    def line(cells):
        return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"
    return "\n".join([line(head), "|" + "---|" * len(head)] + [line(row) for row in rows])
