"""The words of the glossary: phrases that a reader stumbles over do not come back."""

import ast
import io
import json
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

#: What is not said -> what is said instead. Identifiers and keys of files, such as `set_aside`, are
#: no prose: an underscore is part of a word.
BANNED = {
    r"\bset(?:s|ting)? (?:\w+ ){0,2}aside\b": "excluded measurements",
    r"\b(?:tell|tells|told|telling) (?:[\w`]+ ){0,6}apart\b": "distinguish",
    r"\bparted\b": "separated",
    r"\bhides all but\b|\bwhat the model hides\b": "absorbed by the fitted terms",
    r"\bnot to be (?:seen|told)\b": "not testable",
    r"\bfor want of\b": "column missing, or too little variation",
    r"\bheld out:? \(?leave\b": "cross-validated over whole scans, 10 folds",
    r"\bto decide:": "next:",
    r"\bluck(?:y|ily)?\b": "a factor that is the same for all, by its name",
    r"\bwild\b": "noisy, or an outlier",
    r"\bstrangers?\b": "uncatalogued causes, or foreign cells",
}
_PATTERNS = {re.compile(one, re.IGNORECASE): instead for one, instead in BANNED.items()}

#: A record of what was sealed and opened, in the words of its day.
RECORD = ("docs/proof/ledger.md",)


def prose_of_python(text):
    """Return (line, words) for each comment and each text of a source file, f-strings joined."""
    found = [
        (token.start[0], token.string)
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type == tokenize.COMMENT
    ]
    tree = ast.parse(text)
    inside = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for part in ast.walk(node)
        if part is not node
    }
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in inside
        ):
            found.append((node.lineno, node.value))
        elif isinstance(node, ast.JoinedStr):
            parts = [one.value if isinstance(one, ast.Constant) else "x" for one in node.values]
            found.append((node.lineno, "".join(map(str, parts))))
    return found


def prose_of(path):
    """Return (line, words) for what a reader or a user sees of a file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return prose_of_python(text)
    if path.suffix == ".ipynb":
        return [(n, "".join(cell["source"])) for n, cell in enumerate(json.loads(text)["cells"])]
    # A single word in backticks is an identifier.
    return [(1, re.sub(r"`[\w.]+`", "`x`", text))]


def files():
    """Return the files that are read: the program, the manual, the README, its companions."""
    found = [
        *ROOT.glob("pyport/**/*.py"),
        *ROOT.glob("pyport/**/*.js"),
        *ROOT.glob("pyport/**/*.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("docs/*.ipynb"),
        *ROOT.glob("*.md"),
    ]
    names = [one.relative_to(ROOT).as_posix() for one in found]
    return sorted(name for name in names if name not in RECORD)


def said(prose):
    """Return (line, phrase, what to say instead) for each banned phrase in (line, words)."""
    return [
        (line, match.group(), instead)
        for line, words in prose
        for pattern, instead in _PATTERNS.items()
        for match in pattern.finditer(" ".join(words.split()))
    ]


@pytest.mark.parametrize("name", files())
def test_the_words_of_the_glossary_are_used(name):
    """Nothing that a user, a reader or a developer reads says it in the other way."""
    assert said(prose_of(ROOT / name)) == []


@pytest.mark.parametrize(
    ("source", "phrase"),
    [
        ('"""Rows are set\n    aside."""', "set aside"),
        ("# what cannot be told apart\n", "told apart"),
        ("# Tell the two of them apart\n", "Tell the two of them apart"),
        ('print(f"{n} set aside")', "set aside"),
        ('print(f"size {n}, of which the model hides " f"all but {m}")', "hides all but"),
        ("print('for want of a column')", "for want of"),
        ('print(f"Held out (leave one session out)")', "Held out (leave"),
        ("STRANGE = 1  # one stranger", "stranger"),
        ("print('by luck, a wild one')", "luck"),
    ],
)
def test_a_banned_phrase_is_found(source, phrase):
    """In a docstring, a comment, a text, and across the pieces of an f-string and of lines."""
    assert phrase in [one for _, one, _ in said(prose_of_python(source))]


@pytest.mark.parametrize(
    "source",
    [
        "set_aside = report['set_aside']",
        "# the key is `set_aside`",
        "print('excluded: no peak')",
        "told, apart = 1, 2",
    ],
)
def test_names_and_the_right_words_pass(source):
    """Keys of the contract stay, and identifiers are no prose."""
    assert said(prose_of_python(source)) == []
