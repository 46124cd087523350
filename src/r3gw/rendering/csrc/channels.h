// The channels that one rendering pass composites, in the order of their columns. The list is
// written here and nowhere else: Python reads it through torch.ops.r3gw.rendered_channels
// (r3gw.rendering.channels).
#pragma once

#include <string_view>

namespace r3gw {

struct Channel {
  std::string_view name;
  int width;        // Columns per Gaussian, planes of a picture.
  bool is_learned;  // Whether its gradient goes on to what the Gaussians hold in these columns.
};

constexpr Channel kChannels[] = {
    {"colour", 3, true},  // Display values.
    {"depth", 1, true},   // Camera z.
    {"normal", 3, true},  // Of the foreground, world axes.
    // What each set contributes by itself (Layers): its gradient moves Gaussians and changes their
    // opacity, but never their colours.
    {"foreground", 1, false},
    {"sky", 1, false},
};

// What the channels "foreground" and "sky" hold: the sum of a set's three colours, or its opacity.
enum class Layers { kColour, kOpacity };

struct Columns {
  int first, width;
};

// Does not compile for a name that is not in the list.
consteval Columns columns(std::string_view name) {
  int first = 0;
  for (const Channel& channel : kChannels) {
    if (channel.name == name) return {first, channel.width};
    first += channel.width;
  }
  throw "no such channel";
}

consteval int count_columns(bool only_learned) {
  int count = 0;
  for (const Channel& channel : kChannels) {
    if (channel.is_learned || !only_learned) count += channel.width;
  }
  return count;
}

constexpr int kFeatures = count_columns(false);
constexpr int kLearnedFeatures = count_columns(true);  // These come first.
constexpr int kColour = columns("colour").first, kDepth = columns("depth").first;
constexpr int kNormal = columns("normal").first;
constexpr int kForeground = columns("foreground").first, kSky = columns("sky").first;

consteval bool learned_come_first() {
  bool before = true;
  for (const Channel& channel : kChannels) {
    if (channel.is_learned && !before) return false;
    before = channel.is_learned;
  }
  return true;
}
static_assert(learned_come_first(), "the rasterizer takes the number of learned columns");

}  // namespace r3gw
