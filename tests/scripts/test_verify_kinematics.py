"""The claim of `armside verify kinematics`, at one of its seeds."""

from armside.scripts.verifications.kinematics import kinematics


def test_all_statements_hold_at_one_seed():
    table = kinematics([3])
    assert len(table.rows) == 2
    for verdict in table.verdicts:
        assert verdict.holds, verdict.statement
