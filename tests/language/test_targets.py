import json

import pytest

from sloop_ppl.errors import DescriptionError
from sloop_ppl.language import TargetObject, load_targets


def test_targets_are_read(tmp_path):
    path = tmp_path / "targets.json"
    path.write_text(json.dumps([{"id": "Tom", "names": ["tom"], "kind": "cat"}, {"id": "Van"}]))
    assert load_targets(path) == (TargetObject("Tom", ("tom",), None, "cat"), TargetObject("Van"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is not JSON (Expecting property name enclosed in double quotes"),
        ("{}", "holds {}; expected a list of objects with an 'id'"),
        ("[]", "holds []; expected a list of objects with an 'id'"),
        ("[3]", ", entry 1 is 3; expected an object with an 'id'"),
        ('[{"id": ""}]', ", entry 1: field 'id' is ''; expected a word"),
        ('[{"name": "a"}]', ", entry 1: field 'name' is unknown; expected id, names, colour, kind"),
        ('[{"id": "a", "names": "b"}]', ", entry 1: field 'names' is a str; expected a list of"),
        ('[{"id": "a", "kind": 1}]', ", entry 1: field 'kind' is 1; expected a word"),
        ('[{"names": ["a"]}]', ", entry 1: field 'id' is missing; expected a word"),
        ('[{"id": "a", "names": ["b", 3]}]', ", entry 1: field 'names[1]' is 3; expected a word"),
        ("[" * 5000, "is not JSON (more than 64 levels of lists and objects inside one another)"),
        ("[" * 90 + "]" * 90, "is not JSON (more than 64 levels of lists and objects"),
        ('[{"id": NaN}]', "is not JSON (it holds the number NaN; expected finite ones)"),
        ('[{"id": "a"}, {"id": "a"}]', ": id 'a' is given twice; ids are unique"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, text, message):
    path = tmp_path / "t.json"
    path.write_text(text)
    with pytest.raises(DescriptionError) as caught:
        load_targets(path)
    said = str(caught.value)
    assert "\n" not in said
    assert said.replace(f"Targets file '{path}'", "", 1).lstrip().startswith(message.lstrip())
