/**
 * Comparison of screenshots, which the browser decodes.
 * @module
 */

/** The maximum difference per channel of pixels that count as equal. */
const TOLERANCE = 8;

/**
 * Returns the fraction of pixels that differ between two screenshots of the same size.
 * @param {import('playwright-core').Page} page decodes them
 * @param {Buffer} a
 * @param {Buffer} b
 * @returns {Promise<number>} from 0 to 1
 */
export function difference(page, a, b) {
  return page.evaluate(
    async ({ pictures, tolerance }) => {
      const [first, second] = await Promise.all(
        pictures.map(async (base64) => {
          const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
          const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
          const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d', { willReadFrequently: true });
          if (!context) throw new Error('no 2D context');
          context.drawImage(bitmap, 0, 0);
          return context.getImageData(0, 0, bitmap.width, bitmap.height);
        }),
      );
      if (first.width !== second.width || first.height !== second.height) throw new Error('pictures of two sizes');
      let different = 0;
      for (let at = 0; at < first.data.length; at += 4) {
        const differs = [0, 1, 2].some((j) => Math.abs(first.data[at + j] - second.data[at + j]) > tolerance);
        if (differs) different++;
      }
      return different / (first.width * first.height);
    },
    { pictures: [a.toString('base64'), b.toString('base64')], tolerance: TOLERANCE },
  );
}
