"""The text of a PDF that Chromium printed: pages, and what stands on each, by the maps of glyphs to letters."""

import re
import unicodedata
import zlib

_OBJECT = re.compile(rb"(\d+) 0 obj\s(.*?)endobj", re.DOTALL)
_STREAM = re.compile(rb"stream\r?\n(.*?)\r?\nendstream", re.DOTALL)
_FONT = re.compile(rb"/(F\d+) (\d+) 0 R")
_SHOWN = re.compile(rb"/(F\d+) [\d.]+ Tf|<([0-9A-Fa-f]+)>\s*Tj|\[(.*?)\]\s*TJ", re.DOTALL)


def pages(printed):
    """The text of each page, without the spaces, which Chromium leaves out or doubles."""
    objects = {int(number): body for number, body in _OBJECT.findall(printed)}
    fonts = {name: _letters(objects, int(number)) for body in objects.values() for name, number in _FONT.findall(body)}
    sheets = [body for body in objects.values() if re.search(rb"/Type /Page\s", body)]
    return [_text(_stream(objects[int(re.search(rb"/Contents (\d+) 0 R", body)[1])]), fonts) for body in sheets]


def _stream(body):
    data = _STREAM.search(body)[1]
    return zlib.decompress(data) if b"/FlateDecode" in body else data


def _letters(objects, number):
    """Which letters each glyph of a font is."""
    there = re.search(rb"/ToUnicode (\d+) 0 R", objects[number])
    if there is None:
        return {}
    table, letters = _stream(objects[int(there[1])]).decode("ascii"), {}
    for part in re.findall(r"beginbfchar(.*?)endbfchar", table, re.DOTALL):
        for glyph, text in re.findall(r"<(\w+)>\s*<(\w+)>", part):
            letters[int(glyph, 16)] = bytes.fromhex(text).decode("utf-16-be")
    for part in re.findall(r"beginbfrange(.*?)endbfrange", table, re.DOTALL):
        for low, high, text in re.findall(r"<(\w+)>\s*<(\w+)>\s*<(\w+)>", part):
            for rank, glyph in enumerate(range(int(low, 16), int(high, 16) + 1)):
                letters[glyph] = chr(int(text, 16) + rank)
    return letters


def _text(content, fonts):
    letters, characters = {}, []
    for font, alone, several in _SHOWN.findall(content):
        if font:
            letters = fonts.get(font, {})
        for glyphs in [alone] if alone else re.findall(rb"<([0-9A-Fa-f]+)>", several):
            text = glyphs.decode("ascii")
            characters += [letters.get(int(text[at : at + 4], 16), "") for at in range(0, len(text), 4)]
    return "".join(unicodedata.normalize("NFKC", "".join(characters)).split())
