// What can go wrong in navigation, as a value: nothing in this room throws at its caller.
#pragma once

namespace landfix::nav {

enum class Status {
  kOk = 0,
  kNotStarted,        ///< no initial position was given
  kNotFinite,         ///< a NaN or infinity among the inputs
  kBadValue,          ///< a value outside its range: a negative sigma, a focal length of zero
  kBadImage,          ///< empty, not 8-bit with 1 to 4 channels, or of another size than the camera or its mask
  kBelowGround,       ///< the camera is not above the ground plane
  kNothingVisible,    ///< no ray of the camera meets the ground within reach
  kTooLarge,          ///< a patch or window beyond the allowed number of pixels
  kTemplateTooLarge,  ///< the template is larger than the window it is searched in
  kNoTexture,         ///< the image or the map is flat there: nothing to match
  kOutsideMap,        ///< the map covers too little of the search region
  kNoGroundHeight,    ///< the map has no height there and no plane was stated
  kLost,              ///< the filter's probability vanished numerically
  kNoLayer,           ///< the map has no layer that this matcher needs
  kMapError,          ///< the map could not be read
  kImprobable,        ///< a match was found, but the gate demands a higher probability that it is true
  kMapTooOld,         ///< the map is older there than the policy allows, or does not say how old it is
  kInternal,          ///< a library failed: out of memory, or a defect
};

/// One English sentence that says what happened and what to do; never null.
const char* to_text(Status status);

}  // namespace landfix::nav
