"""The layers of a sheet that is folded flat: whether they have an order, how many, and which.

`layer_orders` is the question that others ask, with `LayerOrders` as its answer.
"""
