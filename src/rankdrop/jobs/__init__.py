"""Long jobs in chunks: on local processes or a Dask cluster, with a journal, so that what is finished is never lost."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
