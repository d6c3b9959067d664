from .inverse import Aim as Aim
