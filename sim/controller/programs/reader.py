"""What the languages have in common: statements, routines, waits, and the moves they end up in.

A text is parsed whole, and refused where it is not understood. Then its statements are carried out
in their order, as the controller does: what a move refers to is what is set by then.
"""

from collections.abc import Callable, Mapping, MutableMapping, Sequence
from typing import ClassVar, NoReturn

from ...motion.instructions import (
    Instruction,
    Move,
    MoveC,
    MoveJ,
    MoveL,
    Program,
    ProgramError,
    Speed,
    Target,
    Wait,
)
from .program_text import Aim, Frame, Language, Place, ProgramText
from .scanner import Cursor, Number, Text, Token, Value

MOST_MOVES = 100_000
DEEPEST_CALL = 30
Statement = Callable[[], object]
End = Callable[[], Aim | Target]


class Reader:
    """Reader of one language; a language adds its grammar, its declarations and its moves."""

    language: ClassVar[Language]
    grammar: ClassVar[str]
    fold: ClassVar[bool] = True
    end: ClassVar[tuple[str, ...]]
    """Signs, or kinds of tokens, that end a statement."""
    routine: ClassVar[tuple[str, str]]
    """Words before and after a routine."""
    head: ClassVar[tuple[str, ...]] = ("(", ")")
    """Signs after the name of a routine."""
    call: ClassVar[tuple[str, ...]]
    """Signs after the name of a routine that is called."""
    wait: ClassVar[tuple[str, ...]]
    moves: ClassVar[Mapping[str, type[Move]]]
    unmoving: ClassVar[frozenset[str]]
    """Instructions that leave path and speed of the program as they are."""

    def __init__(self, texts: Sequence[Text]) -> None:
        self.texts, self.cursor = tuple(texts), Cursor(texts[0], self.grammar, self.fold)
        self.data: MutableMapping[str, Value | Aim] = {}
        self.routines, self.called = dict[str, list[Statement]](), set[str]()
        self.instructions, self.places = list[Instruction](), list[Place]()
        self.tool, self.base, self.depth = Frame("tool"), Frame("base"), 0

    def read(self) -> ProgramText:
        """The program. Raises ProgramError with file, line and column."""
        top = list[Statement]()
        for text in reversed(self.texts):  # data before what uses them
            self.cursor = Cursor(text, self.grammar, self.fold)
            top += self.file()
        for statement in top:
            statement()
        entry = self.entry()
        if not self.places and entry:
            self.run(entry, Token("word", entry, self.texts[0], 0, 0))
        program = Program(
            instructions=tuple(self.instructions),
            source=self.texts[0].name,
            lines=tuple(place.text.line(place.at) for place in self.places),
        )
        return ProgramText(
            language=self.language,
            texts=self.texts,
            program=program,
            places=tuple(self.places),
            entry=entry,
        )

    def entry(self) -> str:
        """Routine that the program starts with: main, or the first that no other calls."""
        free = [name for name in self.routines if name not in self.called]
        return next((n for n in ("main", *free, *self.routines) if n in self.routines), "")

    def file(self) -> list[Statement]:
        """Statements of one file outside of its routines."""
        return self.body("")

    def body(self, last: str) -> list[Statement]:
        """Statements up to a word, which is read, or to the end of the file."""
        cursor, found = self.cursor, list[Statement]()
        while True:
            while cursor.next.kind == "newline":
                cursor.take()
            if last and cursor.has(last):
                return found
            if cursor.next.kind == "end":
                if last:
                    cursor.expect(last)
                return found
            found += self.statement(cursor.next)

    def statement(self, first: Token) -> list[Statement]:
        """What one statement does. Raises ProgramError where it is not understood."""
        cursor, done = self.cursor, list[Statement]()
        if cursor.has(self.routine[0]):
            name = cursor.take("word")
            if name.text in self.routines or name.text in {*self.unmoving, *self.moves}:
                cursor.fail(f"{name} is there already", name)
            cursor.expect(*self.head)
            self.routines[name.text] = []
            self.routines[name.text] += self.body(self.routine[1])
            return []
        if cursor.has(*self.wait):
            cursor.has("\\", "inpos", ",")
            given = cursor.value()
            cursor.has(")")
            done.append(lambda: self._wait(given, self.place(first)))
        elif first.text in self.unmoving and first.kind == "word":
            self.pass_over(first)
        elif first.text in self.moves and first.kind == "word":
            done += self.move(cursor.take())
        elif first.kind == "word" and self._called(first):
            self.called.add(first.text)
            done.append(lambda: self.run(first.text, first))
        else:
            done += self.declaration(first)
        if not self.ends:
            cursor.fail(f"the end of the statement is expected, not {cursor.next}")
        if cursor.next.kind != "end":
            cursor.take()
        return done

    def _wait(self, given: Value, place: Place) -> None:
        seconds = self.number(given).value
        self.add(lambda: Wait(seconds=seconds), place)

    def pass_over(self, first: Token) -> None:
        """An instruction that moves nothing."""
        while not self.ends:
            if (token := self.cursor.take()).text in (*self.moves, *self.routine):
                self.cursor.fail(f"the end of {first} is missing before {token}", token)

    @property
    def ends(self) -> bool:
        """The statement ends here."""
        token = self.cursor.next
        return token.text in self.end or token.kind in (*self.end, "end")

    def _called(self, first: Token) -> bool:
        """A routine's name and call, and the end of the statement; nothing is read if not."""
        start, found = self.cursor.at, self.cursor.has(first.text, *self.call)
        if not (found and self.ends):
            self.cursor.at = start
        return found and self.ends

    def move(self, first: Token) -> list[Statement]:
        """A move, whose word has been read."""
        raise NotImplementedError

    def moving(
        self, first: Token, to: Sequence[End], how: Callable[[], tuple[Speed, float]]
    ) -> Statement:
        """Move to the last of its ends, poses or joint angles, with a speed and a zone."""

        def add() -> None:
            ends = [end() for end in to]
            places = [self.place(first, end) for end in ends]
            if not places[0].base.same(places[-1].base):
                self.refuse(first, "both poses must be in one feature")
            self.add(lambda: self._motion(self.moves[first.text], ends, *how()), places[-1])

        return add

    def _motion(
        self, kind: type[Move], ends: Sequence[Aim | Target], speed: Speed, zone: float
    ) -> Move:
        to = end.target if isinstance(end := ends[-1], Aim) else end
        if kind is MoveL or kind is MoveJ:
            return kind(to=to, speed=speed, zone=zone)
        if not isinstance(ends[0], Aim):
            raise ValueError("MoveC needs two positions")
        x, y, z = map(float, ends[0].pose[:3, 3])
        return MoveC(to=to, speed=speed, zone=zone, via=(x, y, z))

    def declaration(self, first: Token) -> list[Statement]:
        """A declaration or an assignment, which is all that is left."""
        raise NotImplementedError

    def run(self, name: str, at: Token) -> None:
        """Carry out a routine."""
        if name not in self.routines:
            known = ", ".join(list(self.routines)[:8]) or "none"
            self.refuse(at, f"{name} is not in the file. Routines: {known}")
        self.depth += 1
        if self.depth > DEEPEST_CALL:
            self.refuse(at, f"{name} is called {DEEPEST_CALL} deep, or by itself")
        for statement in self.routines[name]:
            statement()
        self.depth -= 1

    def add(self, make: Callable[[], Instruction], place: Place) -> None:
        """Add an instruction; what its class refuses is refused at its place."""
        try:
            self.instructions.append(make())
        except ProgramError:
            raise
        except ValueError as error:
            place.text.fail(place.at, str(error))
        self.places.append(place)
        if len(self.places) > MOST_MOVES:
            place.text.fail(place.at, f"a program has at most {MOST_MOVES} moves")

    def place(self, at: Token, end: Aim | Target | None = None) -> Place:
        """Of an instruction, with tool and work object as they are set."""
        aim = end if isinstance(end, Aim) else None
        base = aim.base if aim and aim.base else self.base
        return Place(text=at.text_of, at=at.start, aim=aim, tool=self.tool, base=base)

    def number(self, given: Value | Aim, at: Token | None = None) -> Number:
        """A number, or the value of its name."""
        value = self.named(given) if isinstance(given, Token) else given
        if not isinstance(value, Number):
            self.refuse(at or given, "a number is expected")
        return value

    def refuse(self, at: Value | Aim | Token, reason: str) -> NoReturn:
        """Raise ProgramError at a value."""
        at = at.point[0] if isinstance(at, Aim) else at
        at.text_of.fail(at.start, reason)

    def named(self, given: Value | Aim) -> Value | Aim:
        """A value, or that of its name."""
        for _ in range(DEEPEST_CALL):
            if not isinstance(given, Token):
                break
            if given.text not in self.data:
                self.refuse(given, f"{given} is not declared in the file")
            given = self.data[given.text]
        return given
