"""The answer for people: words, cards, pages, files."""
