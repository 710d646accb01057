// XML by GDAL's small parser, which expands no entities but the five of XML itself.
#pragma once

#include <cpl_minixml.h>

#include <optional>
#include <string>

namespace landfix::mission {

class XmlDocument {
 public:
  /// Throws Error (kBadInput) where the text is no XML or declares entities.
  XmlDocument(const std::string& text, const std::string& file);
  const CPLXMLNode* root() const { return root_; }

 private:
  CPLXMLTreeCloser tree_;
  const CPLXMLNode* root_ = nullptr;
};

/// The name of an element without its namespace's prefix.
std::string local_name(const CPLXMLNode* element);

/// The next element at or after a node among its siblings; null at their end.
const CPLXMLNode* element_from(const CPLXMLNode* node);

inline const CPLXMLNode* first_element(const CPLXMLNode* parent) { return element_from(parent->psChild); }
inline const CPLXMLNode* next_element(const CPLXMLNode* element) { return element_from(element->psNext); }

/// The text of an element itself, without that of elements in it.
std::string text_of(const CPLXMLNode* element);

/// The text of the first child element of this local name.
std::optional<std::string> child_text(const CPLXMLNode* parent, const std::string& name);

std::optional<std::string> attribute(const CPLXMLNode* element, const std::string& name);

}  // namespace landfix::mission
