#include "roadgen/import/xml_parts.h"

#include <algorithm>

namespace roadgen {
namespace {

constexpr std::size_t kNone = std::string_view::npos;

// One past the end of the tag that starts at `at`: beyond its ">" outside quotes. npos where it does not end.
std::size_t tag_end(std::string_view text, std::size_t at) {
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '>') return at + 1;
    if (c != '"' && c != '\'') continue;
    at = text.find(c, at + 1);
    if (at == kNone) break;
  }
  return kNone;
}

// One past the end of <!DOCTYPE ...>, which may hold further tags.
std::size_t doctype_end(std::string_view text, std::size_t at) {
  int depth = 0;
  while ((at = text.find_first_of("<>", at)) != kNone) {
    depth += text[at++] == '<' ? 1 : -1;
    if (depth == 0) return at;
  }
  return kNone;
}

enum class Markup { kOther, kStart, kEmpty, kEnd };

// What begins with "<" at `at`, and one past its end.
struct Found {
  Markup markup = Markup::kOther;
  std::size_t end = kNone;
};
Found markup_at(std::string_view text, std::size_t at) {
  const std::string_view rest = text.substr(at);
  const auto through = [&](std::string_view mark, std::size_t skipped) {
    const std::size_t end = text.find(mark, at + skipped);
    return Found{Markup::kOther, end == kNone ? kNone : end + mark.size()};
  };
  if (rest.starts_with("<!--")) return through("-->", 4);
  if (rest.starts_with("<![CDATA[")) return through("]]>", 9);
  if (rest.starts_with("<?")) return through("?>", 2);
  if (rest.starts_with("<!DOCTYPE")) return {Markup::kOther, doctype_end(text, at)};
  const std::size_t end = tag_end(text, at);
  if (rest.starts_with("</")) return {Markup::kEnd, end};
  const bool is_empty = end != kNone && text[end - 2] == '/';
  return {is_empty ? Markup::kEmpty : Markup::kStart, end};
}

// One past the end of the element whose start tag ends at `at`; counts the tags.
std::size_t element_end(std::string_view text, std::size_t at, std::size_t& tags) {
  for (int depth = 1; depth > 0;) {
    at = text.find('<', at);
    if (at == kNone) return kNone;
    const Found found = markup_at(text, at);
    if (found.end == kNone) return kNone;
    if (found.markup == Markup::kStart) ++depth;
    if (found.markup == Markup::kEnd) --depth;
    ++tags;
    at = found.end;
  }
  return at;
}

}  // namespace

XmlParts xml_parts(std::string_view text, std::size_t most_children) {
  Found root;
  for (std::size_t at = text.find('<'); at != kNone; at = text.find('<', root.end)) {
    root = markup_at(text, at);
    if (root.markup != Markup::kOther || root.end == kNone) break;
  }
  if (root.markup != Markup::kStart || root.end == kNone) return {{}, text, {}};

  XmlParts parts{{}, text.substr(0, root.end), {}};
  std::size_t counted = 0;
  int line = 1;
  const auto line_of = [&](std::size_t at) {
    const auto from = text.begin() + static_cast<std::ptrdiff_t>(counted);
    line += static_cast<int>(std::count(from, text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    counted = at;
    return line;
  };
  std::size_t at = text.find('<', root.end);
  while (at != kNone && parts.children.size() <= most_children) {
    const Found found = markup_at(text, at);
    const bool other = found.markup == Markup::kOther;
    if (found.markup == Markup::kEnd || (other && found.end == kNone)) break;
    std::size_t tags = 1;
    const std::size_t end =
        found.markup == Markup::kStart && found.end != kNone ? element_end(text, found.end, tags) : found.end;
    if (!other) parts.children.push_back({text.substr(at, end == kNone ? kNone : end - at), line_of(at), tags});
    at = end == kNone ? kNone : text.find('<', end);
  }
  at = std::min(at, text.size());
  parts.after = {text.substr(at), line_of(at)};
  return parts;
}

}  // namespace roadgen
