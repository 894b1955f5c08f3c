"""Tables, figures and pages for terminal, Markdown and HTML; with commands and scripts the only package that draws.

Numbers of reports are computed in the packages of their subjects, figures of merit in `ffgym.recordings.metrics`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
