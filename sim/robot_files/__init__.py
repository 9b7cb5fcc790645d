"""Robot files made: a commented one from a URDF, an MJCF, a D-H table or a template, and the file
beside an MJCF that was built."""

from .commented import commented as commented
from .source import Source as Source
from .source import read_source as read_source
from .source import template as template
from .written import built_files as built_files
