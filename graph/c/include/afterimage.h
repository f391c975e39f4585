/* Afterimage for C: pipelines on images in memory. Written by cbindgen from src/lib.rs. */

#ifndef AFTERIMAGE_H
#define AFTERIMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * Codes of 8 bits.
 */
#define AFTERIMAGE_U8 1

/**
 * Codes of 16 bits.
 */
#define AFTERIMAGE_U16 2

/**
 * 16-bit floats.
 */
#define AFTERIMAGE_F16 3

/**
 * 32-bit floats.
 */
#define AFTERIMAGE_F32 4

/**
 * A pipeline. One thread at a time may use it.
 */
typedef struct AfterimagePipeline AfterimagePipeline;

/**
 * An image in memory: rows from the top without gaps, the channels of a pixel side by side, the slices of a volume one
 * after another.
 */
typedef struct {
  /**
   * The name of the input or output.
   */
  const char *name;
  /**
   * The numbers. They have the byte order and the alignment of the processor.
   */
  const void *numbers;
  /**
   * Pixels of a row.
   */
  uint32_t width;
  /**
   * Rows.
   */
  uint32_t height;
  /**
   * Numbers of a pixel: 4; for inputs of data also 1 (or 2 of 16 bits); for outputs 1 to 4.
   */
  uint32_t channels;
  /**
   * `AFTERIMAGE_F16` or `AFTERIMAGE_F32`; for outputs also `AFTERIMAGE_U8` or `AFTERIMAGE_U16`.
   */
  uint32_t number_type;
  /**
   * Slices of a volume; 0 for an image that is none.
   */
  uint32_t slices;
} AfterimageImage;

/**
 * A camera. A matrix has its columns one after another.
 */
typedef struct {
  /**
   * The name of the input.
   */
  const char *name;
  /**
   * From the world to the camera, which looks along -z with y upwards.
   */
  float view[16];
  /**
   * From the camera to clip space, without jitter; depth is from 0 to 1, with the near plane at either end.
   */
  float projection[16];
  /**
   * `view` of the frame before; the same as `view` in a first frame.
   */
  float previous_view[16];
  /**
   * `projection` of the frame before.
   */
  float previous_projection[16];
  /**
   * How far the samples lie from the centers of pixels, in pixels, y downwards.
   */
  float jitter[2];
  /**
   * `jitter` of the frame before.
   */
  float previous_jitter[2];
} AfterimageCamera;

/**
 * Limits that `afterimage_govern` holds.
 */
typedef struct {
  /**
   * The budget in milliseconds.
   */
  double ms;
  /**
   * The least claim in JOD of a tier that may be chosen, 10 for no visible difference; 0 for no such limit. If no
   * tier reaches it, the best claim is the only choice, and the budget is not held.
   */
  double min_jod;
  /**
   * The display whose claims count, as `measure --display` names it; null for any.
   */
  const char *display;
} AfterimageLimits;

/**
 * A frame to render.
 */
typedef struct {
  /**
   * Images of the inputs: light as linear Rec.709.
   */
  const AfterimageImage *images;
  /**
   * Number of images.
   */
  size_t image_count;
  /**
   * Cameras of the inputs.
   */
  const AfterimageCamera *cameras;
  /**
   * Number of cameras.
   */
  size_t camera_count;
  /**
   * Pixels of a row, for a pipeline without images.
   */
  uint32_t width;
  /**
   * Rows, for a pipeline without images.
   */
  uint32_t height;
  /**
   * The number of the frame, from which noise is made.
   */
  uint32_t number;
  /**
   * Seconds since the start.
   */
  double time;
  /**
   * Seconds since the frame before.
   */
  float dt;
  /**
   * 0 for a first frame. Otherwise histories and adaptation go on from the frame before.
   */
  uint32_t continues;
} AfterimageFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The text of the last error on this thread; it is valid until the next one. Empty if there was none.
 */
const char *afterimage_error(void);

/**
 * Opens a pipeline: the path of a file, the name of a built-in pipeline, or a text with `Pipeline(`. Returns null
 * after an error.
 *
 * # Safety
 * `source` is null or a text with a zero at its end.
 */
AfterimagePipeline *afterimage_open(const char *source);

/**
 * Frees a pipeline and its outputs. Null is allowed.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`, and is not used afterwards.
 */
void afterimage_free(AfterimagePipeline *pipeline);

/**
 * Sets a parameter, `node.parameter`, to a value as a pipeline file writes it, or switches a node: `On` or `Off`.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`; the others are null or texts with a zero at their ends.
 */
bool afterimage_set(AfterimagePipeline *pipeline, const char *name, const char *value);

/**
 * Changes to a tier; null is the pipeline without one.
 *
 * # Safety
 * As for `afterimage_set`.
 */
bool afterimage_set_tier(AfterimagePipeline *pipeline, const char *tier);

/**
 * Holds limits from the next frame on: chooses one of these tiers, which are in order from the worst picture to the
 * best, by the times that `afterimage_report_frame_time` gets. Null `limits` keep the present tier from now on, as
 * `afterimage_set_tier` does.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`, `limits` is null or limits, and `tiers` is null or has `tier_count`
 * elements, which are null or texts with a zero at their ends.
 */
bool afterimage_govern(AfterimagePipeline *pipeline,
                       const AfterimageLimits *limits,
                       const char *const *tiers,
                       size_t tier_count);

/**
 * Reports the milliseconds of the last frame, and the seconds since the frame before, to `afterimage_govern`. The next
 * frame has the tier that it then chooses.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`.
 */
bool afterimage_report_frame_time(AfterimagePipeline *pipeline, double ms, double dt);

/**
 * The name of the present tier; null for the pipeline without one. It is valid until the next call of this function
 * for the pipeline, or until that is freed.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`, `tier` is null or may be written.
 */
bool afterimage_tier(AfterimagePipeline *pipeline, const char **tier);

/**
 * The reason why the limits of `afterimage_govern` are not held at present; null if they are. It is valid until the
 * next call of this function for the pipeline, or until that is freed.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`, `shortfall` is null or may be written.
 */
bool afterimage_shortfall(AfterimagePipeline *pipeline, const char **shortfall);

/**
 * States a fact that is true or false.
 *
 * # Safety
 * As for `afterimage_set`.
 */
bool afterimage_set_flag(AfterimagePipeline *pipeline, const char *name, bool flag);

/**
 * States a fact that is a number.
 *
 * # Safety
 * As for `afterimage_set`.
 */
bool afterimage_set_number(AfterimagePipeline *pipeline, const char *name, double number);

/**
 * The type of the numbers of outputs for a display; 0 for the codes of the program's PNG files: `AFTERIMAGE_U8`, and
 * `AFTERIMAGE_U16` for PQ and HLG. Floats are from 0 to 1 and not rounded. Light has the type that the pipeline
 * stores.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`.
 */
bool afterimage_set_type(AfterimagePipeline *pipeline, uint32_t number_type);

/**
 * Renders a frame, and waits for it.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`. `frame` is null or a frame with as many images, cameras and numbers as
 * it says.
 */
bool afterimage_render(AfterimagePipeline *pipeline, const AfterimageFrame *frame);

/**
 * An output of the last frame; a null name is the first one. Its memory is valid until the next frame, or until the
 * pipeline is freed.
 *
 * # Safety
 * `pipeline` is null or of `afterimage_open`, `name` is null or a text with a zero at its end, `image` is null or may
 * be written.
 */
bool afterimage_output(AfterimagePipeline *pipeline, const char *name, AfterimageImage *image);

/**
 * Four numbers of a value of the last frame, `node.port` or `node`, such as the exposure of a meter: stops, log2 of
 * the metered luminance, lux, and 1 once it is valid.
 *
 * # Safety
 * As for `afterimage_output`; `numbers` is null or has room for four.
 */
bool afterimage_value(AfterimagePipeline *pipeline, const char *name, float *numbers);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* AFTERIMAGE_H */
