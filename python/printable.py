"""Text for a terminal, and command lines with names in it."""
import argparse


def printable(text):
    """The text with its control characters escaped: a name must not command the terminal that shows it."""
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in str(text))


class Parser(argparse.ArgumentParser):
    """Refuses empty names, and shows what is wrong without control characters."""

    def error(self, message):
        super().error(printable(message))

    def require_names(self, asked, **options):
        """options: how an argument is called, by its name in `asked`."""
        for name, option in options.items():
            if getattr(asked, name) == "":
                self.error(f"{option} takes a name, and is empty")
