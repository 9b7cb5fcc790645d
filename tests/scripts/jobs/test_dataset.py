"""Types of columns by those of fields."""

from typing import Literal

import pyarrow as pa
import pytest

from armside.scripts.jobs.dataset import _arrow


@pytest.mark.parametrize(
    ("hint", "kind"),
    [
        (float, pa.float64()),
        (float | None, pa.float64()),
        (int | str, pa.string()),
        (bool, pa.bool_()),
        (Literal["a", "b"], pa.string()),
        (tuple[int, ...], pa.list_(pa.int64())),
    ],
)
def test_a_column_has_the_type_of_its_field_whether_or_not_it_may_be_empty(hint, kind):
    assert _arrow(hint) == kind
