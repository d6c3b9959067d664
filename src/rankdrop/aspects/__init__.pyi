from .count import AspectCount as AspectCount
from .count import SignCount as SignCount
from .count import count_aspects as count_aspects
