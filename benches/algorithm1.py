#!/usr/bin/env python3
"""Algorithm 1 of the paper in PyTorch, straightforwardly: one node at a time, on one CPU thread.

    python benches/algorithm1.py models/paper.safetensors oak --trees 10 --budget 5000

reads a model of kind `paper`, grows trees of a species, and prints one object of JSON: for each tree
its nodes, branches, seconds and whether the budget cut it short, and, to check the networks by, what
the classifier says of the first roots of the model. `deeptree evaluate --chapters runtime` runs it.

The signatures are those of crates/graph/src/signature/paper.rs. As in the rest of this repository a
child exists when α < p_i; as printed (α > p_i) the labels would mean the opposite. As printed, and
unlike there, a regressor is handed the signatures of all earlier siblings, existing or not.
"""

import argparse
import json
import math
import random
import struct
import time
from collections import deque

import torch

SPACE = 64.0
CHECKED_ROOTS = 8


def read_safetensors(path):
    """The tensors of a file, and its metadata."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    meta = header.pop("__metadata__")
    body = bytearray(data[8 + length :])
    tensors = {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        tensor = torch.frombuffer(body[begin:end], dtype=torch.float32)
        tensors[name] = tensor.reshape(entry["shape"]).clone()
    return tensors, meta


def network(tensors, name):
    """Dense layers with rectifiers between them; the file holds weights as [inputs, outputs]."""
    layers, i = [], 0
    while f"{name}.{i}.weight" in tensors:
        weight = tensors[f"{name}.{i}.weight"]
        layer = torch.nn.Linear(*weight.shape)
        layer.weight.data = weight.T.contiguous()
        layer.bias.data = tensors[f"{name}.{i}.bias"]
        layers += [layer, torch.nn.ReLU()]
        i += 1
    return torch.nn.Sequential(*layers[:-1])


def multiply(a, b):
    """The product of two quaternions x, y, z, w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def normalize(q):
    norm = math.sqrt(sum(x * x for x in q))
    return tuple(x / norm for x in q) if norm > 1e-6 else (0.0, 0.0, 0.0, 1.0)


def front(q):
    """R · [0, 0, −1]."""
    x, y, z, w = q
    return (-2.0 * (x * z + w * y), -2.0 * (y * z - w * x), -1.0 + 2.0 * (x * x + y * y))


class Node:
    """A node with the attributes of Eq. 1."""

    def __init__(self, parent, slot, siblings, rotation, thickness, length):
        self.rotation, self.thickness, self.length = rotation, thickness, length
        self.siblings = siblings
        lateral = slot > 0
        if parent is None:
            self.orientation = rotation
            start, root_distance, branch_distance, self.order = (0.0, 0.0, 0.0), 0.0, 0.0, 0
        else:
            self.orientation = normalize(multiply(parent.orientation, rotation))
            start, root_distance = parent.position, parent.root_distance
            branch_distance = 0.0 if lateral else parent.branch_distance
            self.order = parent.order + lateral
        direction = front(self.orientation)
        self.position = tuple(p + length * d for p, d in zip(start, direction))
        self.root_distance = root_distance + length
        self.branch_distance = branch_distance + length


class Model:
    def __init__(self, path):
        self.tensors, meta = read_safetensors(path)
        self.species = meta["species"].split(",")
        self.classifier = network(self.tensors, "classifier")
        self.regressors = [network(self.tensors, f"regressor{i}") for i in (1, 2, 3)]

    def signature(self, node, species, age, gravitropism):
        one_hot = [0.0] * len(self.species)
        one_hot[species] = 1.0
        return torch.tensor(
            [p / SPACE for p in node.position]
            + [node.thickness, node.root_distance / SPACE, node.branch_distance / SPACE]
            + list(node.rotation)
            + [node.length, node.order / 8.0, node.siblings / 3.0, age / 64.0, gravitropism]
            + one_hot
        )

    def root(self, species, row):
        """The root of training tree `row`, its age and its gravitropism."""
        numbers = self.tensors[f"roots.{self.species[species]}"][row].tolist()
        node = Node(None, 0, 1, tuple(numbers[:4]), numbers[4], numbers[5])
        return node, numbers[6], numbers[7]

    def roots(self, species):
        return len(self.tensors[f"roots.{self.species[species]}"])


def grow(model, species, seed, budget):
    """Algorithm 1: the number of nodes and of branches, and whether the budget cut the tree short."""
    draw = random.Random(seed)
    root, age, gravitropism = model.root(species, draw.randrange(model.roots(species)))
    nodes, branches, cut = 1, 1, False
    active = deque([root])
    while active and not cut:
        node = active.popleft()
        n = model.signature(node, species, age, gravitropism)
        x = torch.sigmoid(model.classifier(n)).tolist()
        signatures = []
        for regressor in model.regressors:
            signatures.append(regressor(torch.cat([n, *signatures])))
        exists = [draw.random() < p for p in x]
        if nodes + sum(exists) > budget:
            cut = True
            break
        for slot in (i for i in range(3) if exists[i]):
            u = signatures[slot].tolist()
            thickness, length = min(max(u[4], 1e-4), SPACE), min(max(u[5], 0.0), SPACE)
            child = Node(node, slot, sum(exists), normalize(u[:4]), thickness, length)
            active.append(child)
            nodes += 1
            branches += slot > 0
    return nodes, branches, cut


def main():
    parser = argparse.ArgumentParser(description="Algorithm 1 in PyTorch, node by node.")
    parser.add_argument("model")
    parser.add_argument("species")
    parser.add_argument("--trees", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--budget", type=int, default=5000)
    parser.add_argument("--repeats", type=int, default=1)
    args = parser.parse_args()

    torch.set_num_threads(1)
    torch.set_grad_enabled(False)
    model = Model(args.model)
    if args.species not in model.species:
        parser.error(f"the model knows {', '.join(model.species)}")
    species = model.species.index(args.species)

    roots = [model.root(species, row) for row in range(CHECKED_ROOTS)]
    checked = [torch.sigmoid(model.classifier(model.signature(r[0], species, *r[1:]))) for r in roots]

    grow(model, species, args.seed, 100)  # to warm up
    trees = []
    for seed in range(args.seed, args.seed + args.trees):
        times = []
        for _ in range(args.repeats):
            start = time.perf_counter()
            nodes, branches, cut = grow(model, species, seed, args.budget)
            times.append(time.perf_counter() - start)
        trees.append({"nodes": nodes, "branches": branches, "cut": cut, "seconds": min(times)})
    nodes, seconds = (sum(tree[key] for tree in trees) for key in ("nodes", "seconds"))
    print(
        json.dumps(
            {
                "torch": torch.__version__,
                "species": args.species,
                "classifier": [x.tolist() for x in checked],
                "trees": trees,
                "nodes": nodes,
                "seconds": seconds,
                "nodes_a_second": nodes / seconds,
            }
        )
    )


if __name__ == "__main__":
    main()
