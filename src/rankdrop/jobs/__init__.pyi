from .folder import Folder as Folder
from .folder import Job as Job
from .folder import Progress as Progress
from .folder import progress_of as progress_of
from .running import MOST_WORKERS as MOST_WORKERS
from .running import Engine as Engine
from .running import check_engine as check_engine
from .running import finish as finish
