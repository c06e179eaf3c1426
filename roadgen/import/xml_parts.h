// An XML document's root element, divided into the texts of its children, so that each can be parsed by itself: on all
// cores, and without all of the document's tree in memory.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace roadgen {

struct XmlPart {
  std::string_view text;
  int line = 1;          // where it begins
  std::size_t tags = 1;  // in it
};

struct XmlParts {
  // The children; comments, processing instructions and text between them are left out.
  std::vector<XmlPart> children;
  // What stands before the first child and after the last: a document whose root has no children.
  std::string_view before;
  XmlPart after;
};

// Finds tags alone: what is not well-formed stays so in the part where it stands, or in `before` and `after` together,
// for the parser to tell. Ends after most_children and one more, which then are not all. Cost: O(size).
XmlParts xml_parts(std::string_view text, std::size_t most_children);

}  // namespace roadgen
