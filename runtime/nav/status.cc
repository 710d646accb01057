#include "runtime/nav/status.h"

namespace landfix::nav {

const char* to_text(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kNotStarted:
      return "no initial position was given: call start first";
    case Status::kNotFinite:
      return "an input is NaN or infinite: check the sensors";
    case Status::kBadValue:
      return "an input or option is outside its range: standard deviations must not be negative, focal lengths and "
             "ground sample distances must be positive";
    case Status::kBadImage:
      return "the image is empty, not 8-bit with 1 to 4 channels, or not of the camera's (and mask's) size";
    case Status::kBelowGround:
      return "the camera is not above the ground: check barometer, vertical datum and stated plane";
    case Status::kNothingVisible:
      return "the camera sees no ground within three heights: check roll and pitch";
    case Status::kTooLarge:
      return "more pixels than allowed: ask for a coarser ground sample distance";
    case Status::kTemplateTooLarge:
      return "the template is larger than the window it is searched in: ask for a larger window";
    case Status::kNoTexture:
      return "the image or the map is flat here: nothing to match";
    case Status::kOutsideMap:
      return "the map covers too little of the search region";
    case Status::kNoGroundHeight:
      return "the map has no ground height here: state the height of a plane";
    case Status::kLost:
      return "the filter and the measurement exclude each other: start again with a larger uncertainty";
    case Status::kNoLayer:
      return "the map has no layer that this matcher needs: build the pack with it, or choose another matcher";
    case Status::kImprobable:
      return "no fix: the probability that the match is true is below the gate's";
    case Status::kMapTooOld:
      return "no fix: the map here is older than the policy allows, or does not say how old it is";
    case Status::kMapError:
      return "the map could not be read: verify the pack";
    case Status::kInternal:
      return "a library failed: out of memory or a defect";
  }
  return "unknown status";
}

}  // namespace landfix::nav
