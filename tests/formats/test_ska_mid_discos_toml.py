"""SKA-Mid's JSON, DISCOS's XML, and models as TOML."""

import json
from decimal import Decimal

import pytest

from pyport.errors import BadInput
from pyport.formats import models
from pyport.formats.convert import convert
from pyport.formats.models import load
from pyport.models.terms.field_system import UNITS


def coefficients(**values):
    """Return SKA-Mid's eighteen, zero but for these."""
    return {
        name: {
            "value": values.get(name, 0.0),
            "units": unit,
            "stderr": None,
            "used": name in values,
        }
        for name, unit in UNITS.items()
    }


def ska(tmp_path, **values):
    """Write a global pointing model and return its path."""
    path = tmp_path / "own.json"
    tree = {"interface": "https://schema.skao.int/ska-mid-dish-gpm/1.2", "antenna": "SKA063"}
    tree |= {"band": "Band_2", "attrs": {"comment": "mine", "eb_ids": ["eb-1"]}}
    path.write_text(json.dumps(tree | {"coefficients": coefficients(**values)}))
    return path


def test_ska_mids_model_comes_back(tmp_path):
    """Through TOML: values, errors, and all that is said about them."""
    path = ska(tmp_path, IA=-491.05237180985154, IE=1655.986889730121)

    convert(str(path), tmp_path / "x.toml")
    convert(str(tmp_path / "x.toml"), tmp_path / "y.json")

    assert json.loads((tmp_path / "y.json").read_text()) == json.loads(path.read_text())


def test_ska_mids_model_from_tpoint_has_all_eighteen(tmp_path):
    """TF is ECEC of the other sign; what is missing is zero and not used."""
    (tmp_path / "m.mod").write_text("mine\nT 1 1 0 0\n  IA  +12.5  0.5\n =TF  -3.25\nEND\n")

    convert(str(tmp_path / "m.mod"), tmp_path / "x.json")

    found = json.loads((tmp_path / "x.json").read_text())["coefficients"]
    assert list(found) == list(UNITS)
    assert found["IA"] == {"value": 12.5, "units": "arcsec", "stderr": 0.5, "used": True}
    assert found["ECEC"] == {"value": 3.25, "units": "arcsec", "stderr": None, "used": False}


def test_only_coefficients_that_count_are_terms(tmp_path):
    """What is not used and zero is none; what is not used and not zero is held."""
    path = ska(tmp_path, IA=1.0)
    tree = json.loads(path.read_text())
    tree["coefficients"]["IE"]["value"] = 5.0
    path.write_text(json.dumps(tree))

    terms = load(str(path)).terms

    assert [(t.effect.coefficients[0].name, t.fixed) for t in terms] == [
        ("IA", False),
        ("IE", True),
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda tree: tree["coefficients"].pop("CA"), "lacks CA"),
        (lambda tree: tree["coefficients"].update(TX={}), "has TX too many"),
        (lambda tree: tree["coefficients"]["CA"].update(value="x"), "CA has no value"),
        (lambda tree: tree["coefficients"]["CA"].update(units="deg"), "CA is in 'deg'"),
        (lambda tree: tree["coefficients"]["CA"].update(used=3), "CA has a stderr or used"),
        (lambda tree: tree.pop("coefficients"), "no 'coefficients'"),
    ],
)
def test_a_bad_model_of_ska_mid_is_refused(tmp_path, change, words):
    """With what is wrong and what was expected."""
    path = ska(tmp_path)
    tree = json.loads(path.read_text())
    change(tree)
    path.write_text(json.dumps(tree))

    with pytest.raises(BadInput, match=words):
        models.read(path)


def test_no_json_names_its_line(tmp_path):
    """The parser's own place."""
    path = tmp_path / "bad.json"
    path.write_text('{\n "a": ,\n}')

    with pytest.raises(BadInput, match=r"bad\.json:2: not JSON"):
        models.read(path)


def test_more_than_the_dish_takes_is_refused(tmp_path):
    """The range of the dish structure; nothing is written."""
    (tmp_path / "m.mod").write_text("mine\nT 1 1 0 0\n  IA  +2001\nEND\n")

    with pytest.raises(BadInput, match="IA is 2001, expected at most 2000"):
        convert(str(tmp_path / "m.mod"), tmp_path / "x.json")
    assert not (tmp_path / "x.json").exists()


RECEIVER = """<Receiver>
 <receiverCode>{}</receiverCode>
 <phi>90.0</phi>
 {}
</Receiver>"""
XML = """<?xml version='1.0' encoding='ISO-8859-1'?>
<!-- receivers -->
<PointingModel xmlns="urn:schemas-cosylab-com:PointingModel:1.0">
{}
</PointingModel>
"""


def discos(tmp_path, *codes, flag=1):
    """Write a file with a receiver for each code: P1 is 0.1, 0.2, ..."""
    rows = []
    for n, code in enumerate(codes, 1):
        pairs = [
            f"<coefficientNum{k:02d}> {flag if k == 0 else 0} </coefficientNum{k:02d}>"
            f"<coefficientVal{k:02d}> {'0.' + str(n) if k == 0 else 0} </coefficientVal{k:02d}>"
            for k in range(30)
        ]
        rows.append(RECEIVER.format(code, "\n".join(pairs)))
    path = tmp_path / "PointingModel.xml"
    path.write_text(XML.format("\n".join(rows)))
    return path


def test_a_receiver_is_picked_by_its_code(tmp_path):
    """`FILE#CODE`, for conversions and for --model."""
    path = discos(tmp_path, "CCB", "KKG")

    assert models.read(f"{path}#KKG").entries[0].value == Decimal("0.2")
    (term,) = load(f"{path}#CCB").terms
    assert term.effect.id == "azimuth_zero"
    with pytest.raises(BadInput, match="expected FILE#CODE with one of CCB, KKG"):
        models.read(path)


def test_one_receiver_needs_no_code_and_comes_back(tmp_path):
    """Thirty parameters, the code and phi."""
    path = discos(tmp_path, "XB")
    convert(str(path), tmp_path / "back.xml")

    expected, found = models.read(path), models.read(tmp_path / "back.xml")

    assert found == expected


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<a>", "not XML"),
        ("<a/>", "no <Receiver>"),
        ("<!DOCTYPE a><a/>", "document type"),
        ("<a><Receiver><receiverCode>X</receiverCode></Receiver></a>", "no <phi>"),
        (RECEIVER.format("X", "<coefficientVal00>1</coefficientVal00>"), "no <Receiver>"),
    ],
)
def test_bad_xml_is_refused(tmp_path, text, words):
    """Entities included: they can be bombs."""
    path = tmp_path / "bad.xml"
    path.write_text(text)

    with pytest.raises(BadInput, match=words):
        models.read(path)


def test_a_toml_of_terms_is_a_model(tmp_path):
    """Any vocabulary by its own names and units."""
    path = tmp_path / "mine.toml"
    path.write_text(
        'vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_deg = -0.1\nfixed = true\n'
        '[[term]]\nname = "HSCA5CE8"\nvalue_arcsec = -6\n'
    )

    model = load(str(path))

    assert [t.effect.coefficients[0].name for t in model.fitted()] == ["HSCA5CE8"]


IA = 'vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_arcsec = 1\n'
P2 = 'vocabulary = "field-system"\n[[term]]\nname = "P2"\nvalue_deg = 1\n'


def test_whatever_a_toml_says_of_its_terms_is_kept(tmp_path):
    """Dates, times and infinite numbers."""
    path, copy = tmp_path / "mine.toml", tmp_path / "copy.toml"
    said = "day = 2026-11-22\nhour = 07:32:00\nmoment = 2026-11-22T07:32:00Z\n"
    said += "far = [inf, 1.5, 1e-32090000000]\n"
    path.write_text(f"{IA}[details]\n{said}")
    file = models.read(path)
    models.write(file, copy)

    assert models.read(copy).details == file.details
    assert len(file.details) == 4


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('vocabulary = "mine"\n[[term]]\nname = "IA"\nvalue_deg = 1\n', "no vocabulary"),
        ('vocabulary = "tpoint"\n', "no .*term.* table"),
        ('vocabulary = "tpoint"\n[[term]]\nname = "QQ"\nvalue_deg = 1\n', "'QQ' is no term"),
        ('vocabulary = "tpoint"\n[[term]]\nname = "IA"\n', "expects one of value_arcsec"),
        ('vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_deg = "x"\n', "expected a number"),
        ('vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_deg = nan\n', "expected a number"),
        ('vocabulary = "tpoint"\n[[term]]\nname = "IA"\nvalue_deg = 1\nfixed = 2\n', "true or fal"),
        (IA.replace("= 1", "= 9991e-32090000000"), "expected a number"),
        (f"{IA}[details]\nstatistics = 3\n", "statistics is 3, expected a table of numbers"),
        (f"{IA}[details]\nflags = [5]\n", "whole numbers from 0 to 4"),
        (f"{IA}[details]\nnumber_and_date = 2026-11-22\n", "six whole numbers"),
        (f"{IA}[details]\ncomments = 1\n", "expected a text"),
        (f"details = 1\n{IA}", "details is 1, expected a table"),
        (f"phi_deg = 2026-11-22\n{IA}", "phi_deg is .*, expected a number"),
        (f"{P2}[details]\nflags = [1]\n", "1 flags, expected one for each parameter"),
    ],
)
def test_a_bad_toml_of_terms_is_refused(tmp_path, text, words):
    """With what is wrong and what was expected."""
    path = tmp_path / "bad.toml"
    path.write_text(text)

    with pytest.raises(BadInput, match=words):
        load(str(path))
