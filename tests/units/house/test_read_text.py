"""Text files as editors of all systems write them."""

from pipeclamp_models.base.files import read_text
from pipeclamp_models.base.toml_file import read_toml


def test_a_byte_order_mark_is_no_content(tmp_path):
    path = tmp_path / "system.toml"
    path.write_bytes(b"\xef\xbb\xbfname = 'a'\r\nlist = [1,\r2]\r\n")
    assert read_text(path, "a text") == "name = 'a'\nlist = [1,\n2]\n"
    assert read_toml(path) == {"name": "a", "list": [1, 2]}
