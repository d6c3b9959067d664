"""The entries of every kind of file, as tables: they encode, decode strictly, and are the published JSON Schemas."""

from rankdrop.codec import NAMES as NAMES
from rankdrop.codec import check_record as check_record
from rankdrop.codec import load_schema as load_schema
