"""Motion programs of joint and path moves, and their planner."""
