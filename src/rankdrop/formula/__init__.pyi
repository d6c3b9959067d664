from .mathml import typeset as typeset
from .reading import Node as Node
from .reading import parse_conditions as parse_conditions
from .reading import read as read
