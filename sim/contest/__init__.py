"""An open contest of learning control: sealed tasks, entries in processes of their own, ranks.

A task of a round is drawn from HMAC-SHA256(salt, round, track, index): nobody knows the judged ones
before the salt is published, and everybody can judge again afterwards. Rules: docs/contest.md.
"""
