/**
 * How much of a processor a page gets: bars for times hold for one that the test has for itself.
 * @module
 */

const SLICES = 150;
const WARM_UP = 30;

/**
 * Returns how many times longer work takes than on a processor that is not shared: the mean time of equal slices of work, by the shortest one.
 * @param {import('playwright-core').Page} page
 * @returns {Promise<number>} at least 1
 */
export function slowdown(page) {
  return page.evaluate(
    ([count, warmUp]) => {
      const times = [];
      let x = 1;
      for (let slice = 0; slice < count; slice++) {
        const start = performance.now();
        for (let i = 0; i < 2e6; i++) x = Math.imul(x, 1664525) + 1013904223;
        times.push(performance.now() - start);
      }
      // The sum is used, so that the loop is not left out.
      const measured = times.slice(warmUp + (x & 0));
      return measured.reduce((sum, time) => sum + time, 0) / measured.length / Math.min(...measured);
    },
    [SLICES, WARM_UP],
  );
}
