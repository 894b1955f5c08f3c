from .elastic import elastic_feedforward as elastic_feedforward
from .law_agent import LawAgent as LawAgent
from .lugre import dynamic_lugre as dynamic_lugre
from .lugre import static_lugre as static_lugre
