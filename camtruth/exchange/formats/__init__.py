"""One file a format; what `camtruth export` can write is what lies here."""
