"""Make the stored reference trajectories again."""

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from tests.reference import CASES, FILE, solve

if __name__ == "__main__":
    with ProcessPoolExecutor() as pool:
        speeds = np.stack(list(pool.map(solve, CASES)))
    np.savez_compressed(FILE, speeds=speeds)
    print(f"{FILE}: {speeds.shape[0]} runs")
